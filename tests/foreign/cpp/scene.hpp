// The scene and its state, read from request.txt: lines of `key value`.
#include <map>
#include <string>
#include <vector>

#include "vector.hpp"

using Request = std::map<std::string, std::string>;
using State = std::vector<double>;  // position 0-2, velocity 3-5, attitude 6-9 (w, x, y, z), omega in body axes 10-12 of each body

constexpr int SIZE = 13;
struct Body { double mass, radius; Vector inertia; };
struct Spring { int a, b; Vector anchor; double stiffness, length, exponent; };
struct Contact { double stiffness, damping, friction, lever; };
struct Scene { std::vector<Body> bodies; std::vector<Spring> springs; std::vector<Contact> contacts; Vector gravity{}; };

struct Unsupported { std::string why; };

inline Vector at(const State& s, int i) { return {s[i], s[i + 1], s[i + 2]}; }
inline void add(State& s, int i, Vector a) { for (int k = 0; k < 3; k++) s[i + k] += a[k]; }

// A body vector in space axes (way = 1), or a space vector in body axes (way = -1).
inline Vector rotated(const State& s, int i, Vector a, int way) {
    Vector u = double(way) * at(s, i + 7), t = 2.0 * cross(u, a);
    return a + s[i + 6] * t + cross(u, t);
}

inline double number(const Request& r, const std::string& key) { return r.count(key) ? std::stod(r.at(key)) : 0.0; }
inline Vector vector(const Request& r, const std::string& key) { return {number(r, key + ".0"), number(r, key + ".1"), number(r, key + ".2")}; }

inline Scene scene(const Request& r, State& state) {
    Scene found;
    for (int i = 0; i < number(r, "scene.bodies.count"); i++) {
        const std::string b = "scene.bodies." + std::to_string(i) + ".";
        found.bodies.push_back({number(r, b + "mass"), number(r, b + "shape.radius"), vector(r, b + "inertia")});
        for (const char* name : {"position", "velocity"}) for (double x : vector(r, b + name)) state.push_back(x);
        for (int k = 0; k < 4; k++) state.push_back(number(r, b + "attitude." + std::to_string(k)));
        state.resize(state.size() + 3);
        add(state, i * SIZE + 10, rotated(state, i * SIZE, vector(r, b + "omega"), -1));
    }
    for (int i = 0; i < number(r, "scene.elements.count"); i++) {
        const std::string e = "scene.elements." + std::to_string(i) + ".", kind = r.at(e + "kind");
        auto value = [&](const char* name) { return number(r, e + name); };
        // Only springs between centres are known here: an anchor elsewhere would make a torque.
        const Vector off_a = vector(r, e + "anchor_a"), off_b = value("b") < 0 ? Vector{} : vector(r, e + "anchor_b");
        if (dot(off_a, off_a) + dot(off_b, off_b) > 0) throw Unsupported{"anchors off the centre"};
        if (kind == "spring")
            found.springs.push_back({int(value("a")), int(value("b")), vector(r, e + "anchor_b"), value("stiffness"), value("length"), value("exponent")});
        if (kind == "uniform_gravity") found.gravity = found.gravity + vector(r, e + "g");
        if (kind == "contact") {
            if (value("tangential_stiffness") > 0) throw Unsupported{"tangential springs"};
            if (r.at(e + "cutoff") != "zero_overlap") throw Unsupported{"a force that may not pull"};
            const double lever = r.at(e + "branch") == "R" ? 0.0 : r.at(e + "branch") == "R-d" ? 1.0 : 0.5;
            found.contacts.push_back({value("stiffness"), value("damping"), value("friction"), lever});
        }
    }
    return found;
}
