// A small discrete element code in C++: the classical Runge-Kutta method of order 4 for everything, turns included.
// Usage: dem REQUEST.TXT TRAJECTORY.CSV
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>

#include "scene.hpp"

void spring(const Spring& e, const State& s, std::vector<Vector>& force) {
    const Vector to = (e.b < 0 ? e.anchor : at(s, e.b * SIZE)) - at(s, e.a * SIZE);
    const double distance = std::sqrt(dot(to, to)), stretch = distance - e.length;
    if (distance == 0) return;
    const Vector f = std::copysign(e.stiffness * std::pow(std::abs(stretch), e.exponent), stretch) / distance * to;
    force[e.a] = force[e.a] + f;
    if (e.b >= 0) force[e.b] = force[e.b] - f;
}

// Spring and dashpot along the normal n from a to b, sliding friction across it.
void contact(const Contact& e, const Scene& of, const State& s, int a, int b, std::vector<Vector>& force, std::vector<Vector>& torque) {
    const Vector apart = at(s, b * SIZE) - at(s, a * SIZE), between = at(s, a * SIZE + 3) - at(s, b * SIZE + 3);
    const double distance = std::sqrt(dot(apart, apart)), overlap = of.bodies[a].radius + of.bodies[b].radius - distance;
    if (overlap <= 0 || of.bodies[a].radius == 0 || of.bodies[b].radius == 0) return;
    const Vector n = 1 / distance * apart;
    const double closing = dot(between, n), push = e.stiffness * overlap + e.damping * closing;
    const double arm_a = of.bodies[a].radius - e.lever * overlap, arm_b = of.bodies[b].radius - e.lever * overlap;
    const Vector spin_a = rotated(s, a * SIZE, at(s, a * SIZE + 10), 1), spin_b = rotated(s, b * SIZE, at(s, b * SIZE + 10), 1);
    const Vector slip = between - closing * n + cross(arm_a * spin_a + arm_b * spin_b, n);
    const double size = std::sqrt(dot(slip, slip)), rub = size > 0 ? e.friction * std::max(push, 0.0) / size : 0.0;
    const Vector f = -push * n - rub * slip;
    force[a] = force[a] + f, force[b] = force[b] - f;
    torque[a] = torque[a] + arm_a * cross(n, f), torque[b] = torque[b] + arm_b * cross(n, f);
}

State rate(const Scene& of, const State& s) {
    const int n = int(of.bodies.size());
    std::vector<Vector> force(n, Vector{}), torque(n, Vector{});
    for (const Spring& e : of.springs) spring(e, s, force);
    for (const Contact& e : of.contacts)
        for (int b = 1; b < n; b++) for (int a = 0; a < b; a++) contact(e, of, s, a, b, force, torque);
    State found(s.size());
    for (int i = 0, o = 0; i < n; i++, o += SIZE) {
        const Vector w = at(s, o + 10), u = at(s, o + 7), J = of.bodies[i].inertia, L = {J[0] * w[0], J[1] * w[1], J[2] * w[2]};
        add(found, o, at(s, o + 3)), add(found, o + 3, of.gravity + 1 / of.bodies[i].mass * force[i]);
        found[o + 6] = -dot(u, w) / 2, add(found, o + 7, 0.5 * (s[o + 6] * w + cross(u, w)));
        const Vector turning = rotated(s, o, torque[i], -1) - cross(w, L);
        for (int k = 0; k < 3; k++) found[o + 10 + k] = J[k] > 0 ? turning[k] / J[k] : 0;
    }
    return found;
}

void step(const Scene& of, State& s, double h) {
    auto ahead = [&](const State& k, double by) { State t = s; for (size_t i = 0; i < s.size(); i++) t[i] += by * k[i]; return t; };
    const State k1 = rate(of, s), k2 = rate(of, ahead(k1, h / 2)), k3 = rate(of, ahead(k2, h / 2)), k4 = rate(of, ahead(k3, h));
    for (size_t i = 0; i < s.size(); i++) s[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    for (size_t o = 6; o < s.size(); o += SIZE) {
        const double norm = std::hypot(std::hypot(s[o], s[o + 1]), std::hypot(s[o + 2], s[o + 3]));
        for (int k = 0; k < 4; k++) s[o + k] /= norm;
    }
}

int run(const Request& r, const char* path) {
    State s;
    const Scene of = scene(r, s);
    const double start = number(r, "times.0"), interval = number(r, "times.1") - start;
    const long stride = std::lround(number(r, "stride")), samples = std::lround(number(r, "times.count"));
    std::FILE* out = std::fopen(path, "w");
    std::fputs("t,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz\n", out);
    for (long n = 0; n < samples; n++) {
        for (long k = 0; n > 0 && k < stride; k++) step(of, s, interval / stride);
        for (int i = 0, o = 0; i < int(of.bodies.size()); i++, o += SIZE) {
            std::fprintf(out, "%.17g,%d", start + n * interval, i);
            for (int k = 0; k < 10; k++) std::fprintf(out, ",%.17g", s[o + k]);
            for (double x : rotated(s, o, at(s, o + 10), 1)) std::fprintf(out, ",%.17g", x);
            std::fputc('\n', out);
        }
    }
    return std::fclose(out);
}

int main(int, char** argv) {
    std::ifstream file(argv[1]);
    Request request;
    for (std::string key, value; file >> key >> value;) request[key] = value;
    try { return run(request, argv[2]); } catch (const Unsupported& unsupported) { std::cerr << unsupported.why << "\n"; return 77; }
}
