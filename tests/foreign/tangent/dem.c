/* Velocity Verlet in dual numbers: one body on a spring or in gravity, or a ball that bounces on a
   smooth plane. The motion is made once without derivatives, and once for each number of the scene
   that the request asks for, with the slope 1 at that number. */
#include <math.h>

#include "../c/request.h"

/* A number and its derivative by the number that is asked for. */
typedef struct {
    double x, d;
} dual;

static const char *asked = "";

static dual plus(dual a, dual b)
{
    return (dual){a.x + b.x, a.d + b.d};
}
static dual minus(dual a, dual b)
{
    return (dual){a.x - b.x, a.d - b.d};
}
static dual times(dual a, dual b)
{
    return (dual){a.x * b.x, a.d * b.x + a.x * b.d};
}
static dual over(dual a, dual b)
{
    return (dual){a.x / b.x, (a.d - a.x / b.x * b.d) / b.x};
}
static dual root(dual a)
{
    return (dual){sqrt(a.x), a.d / (2 * sqrt(a.x))};
}
static dual plain(double x)
{
    return (dual){x, 0};
}

/* The number of the scene with a key. */
static dual number(const char *key)
{
    return (dual){atof(text("%s", key)), !strcmp(key, asked)};
}

static dual of_body(const char *name)
{
    char key[200];
    snprintf(key, sizeof key, "scene.bodies.0.%s", name);
    return number(key);
}

static dual of_element(int element, const char *name)
{
    char key[200];
    snprintf(key, sizeof key, "scene.elements.%d.%s", element, name);
    return number(key);
}

static void of_axes(dual *out, int element, const char *name)
{
    for (int k = 0; k < 3; k++) {
        char axis[100];
        snprintf(axis, sizeof axis, "%s.%d", name, k);
        out[k] = element < 0 ? of_body(axis) : of_element(element, axis);
    }
}

static dual dot(const dual *a, const dual *b)
{
    return plus(plus(times(a[0], b[0]), times(a[1], b[1])), times(a[2], b[2]));
}

static dual mass, radius, gravity[3], stiffness, anchor[3], normal[3], point[3], restitution;
static int meets_plane;

static void read_scene(void)
{
    mass = of_body("mass");
    radius = of_body("shape.radius");
    stiffness = restitution = plain(0);
    meets_plane = 0;
    for (int k = 0; k < 3; k++)
        gravity[k] = anchor[k] = plain(0);
    for (int e = 0; e < atoi(text("scene.elements.count")); e++) {
        const char *kind = text("scene.elements.%d.kind", e);
        if (!strcmp(kind, "uniform_gravity"))
            of_axes(gravity, e, "g");
        if (!strcmp(kind, "spring")) {
            stiffness = of_element(e, "stiffness");
            of_axes(anchor, e, "anchor_b");
            if (of_element(e, "length").x != 0)
                unsupported("springs of length 0 only");
        }
        if (!strcmp(kind, "contact")) {
            restitution = of_element(e, "restitution");
            if (of_element(e, "friction").x != 0)
                unsupported("contacts without friction only");
        }
        if (!strcmp(kind, "plane")) {
            of_axes(normal, e, "normal");
            of_axes(point, e, "point");
            meets_plane = 1;
        }
    }
}

/* F = m g - k (r - anchor). */
static void force_at(dual *force, const dual *r)
{
    for (int k = 0; k < 3; k++)
        force[k] = minus(times(mass, gravity[k]), times(stiffness, minus(r[k], anchor[k])));
}

/* Kick, drift, kick over a step of dual length. */
static void verlet(dual *r, dual *v, dual h)
{
    dual force[3];
    dual half = over(times(plain(0.5), h), mass);
    force_at(force, r);
    for (int k = 0; k < 3; k++) {
        v[k] = plus(v[k], times(half, force[k]));
        r[k] = plus(r[k], times(h, v[k]));
    }
    force_at(force, r);
    for (int k = 0; k < 3; k++)
        v[k] = plus(v[k], times(half, force[k]));
}

/* When the gap c + b s + a s^2 closes within a step of length `most`; 0 if it does not. */
static int closes(dual *s, const dual *r, const dual *v, double most)
{
    dual force[3], apart[3];
    force_at(force, r);
    for (int k = 0; k < 3; k++)
        apart[k] = minus(r[k], point[k]);
    dual a = over(times(plain(0.5), dot(force, normal)), mass);
    dual b = dot(v, normal);
    dual c = minus(dot(apart, normal), radius);
    dual square = minus(times(b, b), times(plain(4), times(a, c)));
    if (square.x <= 0 || (b.x > 0 && a.x >= 0))
        return 0;
    if (b.x > 0)
        *s = over(plus(b, root(square)), times(plain(-2), a));
    else
        *s = over(times(plain(2), c), minus(root(square), b));
    return s->x >= 0 && s->x < most;
}

/* One step, cut at impacts: v+ = v - (1 + e) (v . n) n. */
static void step(dual *r, dual *v, double h)
{
    dual left = plain(h), s;
    while (meets_plane && closes(&s, r, v, left.x)) {
        verlet(r, v, s);
        dual change = times(plus(plain(1), restitution), dot(v, normal));
        for (int k = 0; k < 3; k++)
            v[k] = minus(v[k], times(change, normal[k]));
        left = minus(left, s);
    }
    verlet(r, v, left);
}

/* Rows of the motion: of its numbers, or of their derivatives by the number that is asked for. */
static void motion(FILE *file, int derivatives)
{
    dual r[3], v[3], omega[3], q[4];
    read_scene();
    of_axes(r, -1, "position");
    of_axes(v, -1, "velocity");
    of_axes(omega, -1, "omega");
    for (int k = 0; k < 4; k++) {
        char name[20];
        snprintf(name, sizeof name, "attitude.%d", k);
        q[k] = of_body(name);
    }
    if (omega[0].x != 0 || omega[1].x != 0 || omega[2].x != 0)
        unsupported("bodies that do not turn only");
    double start = atof(text("times.0"));
    for (int n = 0; n < atoi(text("times.count")); n++) {
        for (int i = 0; n && i < atoi(text("stride")); i++)
            step(r, v, atof(text("step")));
        double t = atof(text("times.%d", n));
        /* q' = omega q/2 at omega = 0: (-omega . u, q0 omega + omega x u)/2 of q = (q0, u). */
        dual half = plain((t - start) / 2), w[3], turned[4];
        for (int k = 0; k < 3; k++)
            w[k] = times(half, omega[k]);
        turned[0] = minus(q[0], dot(w, q + 1));
        for (int k = 0; k < 3; k++) {
            int i = (k + 1) % 3, j = (k + 2) % 3;
            dual across = minus(times(w[i], q[1 + j]), times(w[j], q[1 + i]));
            turned[1 + k] = plus(q[1 + k], plus(times(w[k], q[0]), across));
        }
        dual row[13] = {r[0], r[1], r[2], v[0], v[1], v[2]};
        memcpy(row + 6, turned, sizeof turned);
        memcpy(row + 10, omega, sizeof omega);
        if (derivatives)
            fprintf(file, "%s,", asked);
        fprintf(file, "%.17g,0", t);
        for (int k = 0; k < 13; k++)
            fprintf(file, ",%.17g", derivatives ? row[k].d : row[k].x);
        fprintf(file, "\n");
    }
}

int main(int count, char **words)
{
    const char *header = "t,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz\n";
    if (count != 4)
        return 2;
    read_request(words[1]);
    if (atoi(text("scene.bodies.count")) != 1)
        unsupported("one body only");
    FILE *file = fopen(words[2], "w");
    fputs(header, file);
    motion(file, 0);
    fclose(file);
    int numbers = atoi(text("sensitivities.count"));
    if (numbers == 0)
        return 0;
    file = fopen(words[3], "w");
    fprintf(file, "number,%s", header);
    for (int k = 0; k < numbers; k++) {
        asked = text("sensitivities.%d", k);
        motion(file, 1);
    }
    fclose(file);
    return 0;
}
