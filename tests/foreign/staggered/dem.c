/* A leapfrog whose velocities live half a step before the positions, as in many discrete element
 * codes: it writes x(t) beside v(t - h/2) and says so in refdem.toml. Spheres and points that do
 * not turn. Usage: dem REQUEST.TXT TRAJECTORY.CSV */
#include <math.h>

#include "../c/request.h"

enum { MOST = 16 };
static struct body {
    double m, r[3], v[3], f[3], radius;
} body[MOST];
static struct element {
    char kind;
    int a, b;
    double end[3], k, length, damping;
} element[MOST];
static int bodies, elements;

static double number(const char *name, int i)
{
    return atof(text("scene.elements.%d.%s", i, name));
}

/* Only springs between centres are known here: an anchor elsewhere would make a torque. */
static int is_off_centre(int i, const char *anchor)
{
    double at[3];
    vector(at, 3, "elements", i, anchor);
    return at[0] != 0 || at[1] != 0 || at[2] != 0;
}

static void read_scene(void)
{
    bodies = atoi(text("scene.bodies.count"));
    elements = atoi(text("scene.elements.count"));
    if (bodies > MOST || elements > MOST)
        unsupported("more than 16 bodies or elements");
    for (int i = 0; i < bodies; i++) {
        struct body *b = &body[i];
        b->m = atof(text("scene.bodies.%d.mass", i));
        b->radius = atof(text("scene.bodies.%d.shape.radius", i));
        vector(b->r, 3, "bodies", i, "position");
        vector(b->v, 3, "bodies", i, "velocity");
    }
    for (int i = 0; i < elements; i++) {
        struct element *e = &element[i];
        e->kind = text("scene.elements.%d.kind", i)[0];
        e->a = (int)number("a", i);
        e->b = (int)number("b", i);
        e->k = number("stiffness", i);
        e->length = number("length", i);
        e->damping = number("damping", i);
        vector(e->end, 3, "elements", i, e->kind == 's' ? "anchor_b" : "g");
        if (is_off_centre(i, "anchor_a") || (e->b >= 0 && is_off_centre(i, "anchor_b")))
            unsupported("anchors off the centre");
        if (e->kind == 's' && number("exponent", i) != 1)
            unsupported("springs that are not linear");
        if (e->kind == 'c' && strcmp(text("scene.elements.%d.cutoff", i), "zero_overlap"))
            unsupported("a force that may not pull");
    }
}

/* A force along the line from a to b, towards b where it is positive. */
static void pull(struct body *a, struct body *b, const double *to, double force)
{
    for (int k = 0; k < 3; k++) {
        a->f[k] += force * to[k];
        if (b)
            b->f[k] -= force * to[k];
    }
}

static void forces(void)
{
    for (int i = 0; i < bodies; i++)
        memset(body[i].f, 0, sizeof body[i].f);
    for (struct element *e = element; e < element + elements; e++) {
        for (int i = 0; e->kind == 'u' && i < 3 * bodies; i++)
            body[i / 3].f[i % 3] += body[i / 3].m * e->end[i % 3];
        for (int i = 0; i < bodies; i++) {
            for (int j = e->kind == 'c'                ? i + 1
                         : e->kind == 's' && i == e->a ? e->b
                                                       : bodies;
                 j < bodies; j++) {
                struct body *a = &body[i];
                struct body *b = j < 0 ? NULL : &body[j];
                double to[3], distance;
                double opening = 0;
                for (int k = 0; k < 3; k++)
                    to[k] = (b ? b->r[k] : e->end[k]) - a->r[k];
                distance = sqrt(to[0] * to[0] + to[1] * to[1] + to[2] * to[2]);
                for (int k = 0; k < 3 && distance > 0; k++) {
                    to[k] /= distance;
                    opening += b ? (b->v[k] - a->v[k]) * to[k] : 0;
                }
                if (e->kind == 's')
                    pull(a, b, to, e->k * (distance - e->length));
                if (e->kind == 's')
                    break;
                double overlap = a->radius + b->radius - distance;
                if (overlap > 0 && a->radius * b->radius > 0)
                    pull(a, b, to, e->damping * opening - e->k * overlap);
            }
        }
    }
}

/* Velocities on by h from the forces at the positions. */
static void kick(double h)
{
    forces();
    for (int i = 0; i < 3 * bodies; i++)
        body[i / 3].v[i % 3] += h * body[i / 3].f[i % 3] / body[i / 3].m;
}

int main(int argc, char **argv)
{
    if (argc != 3)
        return fprintf(stderr, "usage: dem REQUEST.TXT TRAJECTORY.CSV\n"), 2;
    read_request(argv[1]);
    read_scene();
    FILE *out = fopen(argv[2], "w");
    fprintf(out, "t,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz\n");
    double t0 = atof(text("times.0"));
    double interval = atof(text("times.1")) - t0;
    long stride = atol(text("stride"));
    long samples = atol(text("times.count"));
    double h = interval / stride;
    kick(-h / 2);
    for (long n = 0; n < samples; n++) {
        for (long step = 0; n > 0 && step < stride; step++) {
            kick(h);
            for (int i = 0; i < 3 * bodies; i++)
                body[i / 3].r[i % 3] += h * body[i / 3].v[i % 3];
        }
        for (int i = 0; i < bodies; i++) {
            const double *r = body[i].r;
            const double *v = body[i].v;
            fprintf(out, "%.17g,%d,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,,,,,,,\n", t0 + n * interval,
                    i, r[0], r[1], r[2], v[0], v[1], v[2]);
        }
    }
    return fclose(out);
}
