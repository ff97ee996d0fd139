/* A small discrete element code: velocity Verlet; bodies turn by exact turns about their principal
 * axes, composed symmetrically (Dullweber, Leimkuhler and McLachlan 1997). Usage: dem REQUEST.TXT
 * TRAJECTORY.CSV EVENTS.CSV */
#include "request.h"
#include "rotation.h"

enum { MOST = 16 };
static struct body {
    double m, J[3], r[3], v[3], q[4], w[3], f[3], torque[3], radius;
} body[MOST]; /* w in body axes */
static struct element {
    char kind;
    int a, b;
    double end[3], k, n, length, damping, friction;
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
        vector(b->J, 3, "bodies", i, "inertia");
        vector(b->r, 3, "bodies", i, "position");
        vector(b->v, 3, "bodies", i, "velocity");
        vector(b->q, 4, "bodies", i, "attitude");
        vector(b->w, 3, "bodies", i, "omega");
    }
    for (int i = 0; i < elements; i++) {
        struct element *e = &element[i];
        e->kind = text("scene.elements.%d.kind", i)[0];
        e->a = (int)number("a", i);
        e->b = (int)number("b", i);
        e->k = number("stiffness", i);
        e->n = number("exponent", i);
        e->length = number("length", i);
        e->damping = number("damping", i);
        e->friction = number("friction", i);
        vector(e->end, 3, "elements", i, e->kind == 's' ? "anchor_b" : "g");
        if (is_off_centre(i, "anchor_a") || (e->b >= 0 && is_off_centre(i, "anchor_b")))
            unsupported("anchors off the centre");
        if (number("tangential_stiffness", i) > 0)
            unsupported("tangential springs");
        if (e->kind == 'c' && strcmp(text("scene.elements.%d.branch", i), "R-d/2"))
            unsupported("lever arms other than R-d/2");
        if (e->kind == 'c' && strcmp(text("scene.elements.%d.cutoff", i), "zero_overlap"))
            unsupported("a force that may not pull");
    }
}

static void spring(const struct element *e)
{
    struct body *a = &body[e->a];
    struct body *b = e->b < 0 ? NULL : &body[e->b];
    double to[3];
    for (int k = 0; k < 3; k++)
        to[k] = (b ? b->r[k] : e->end[k]) - a->r[k];
    double distance = size_of(to);
    double stretch = distance - e->length;
    for (int k = 0; k < 3 && distance > 0; k++) {
        double f = copysign(e->k * pow(fabs(stretch), e->n), stretch) * to[k] / distance;
        a->f[k] += f;
        if (b)
            b->f[k] -= f;
    }
}

/* Spring and dashpot along the normal, sliding friction across it. */
static void contact(const struct element *e, struct body *a, struct body *b)
{
    double n[3], wa[3], wb[3], reach[3], spin[3], slip[3], torque[3], f[3];
    double closing = 0;
    for (int k = 0; k < 3; k++)
        n[k] = b->r[k] - a->r[k];
    double distance = size_of(n);
    double overlap = a->radius + b->radius - distance;
    if (overlap <= 0 || a->radius == 0 || b->radius == 0)
        return;
    for (int k = 0; k < 3; k++) {
        n[k] /= distance;
        closing += (a->v[k] - b->v[k]) * n[k];
    }
    double force = e->k * overlap + e->damping * closing;
    double arm_a = a->radius - overlap / 2;
    double arm_b = b->radius - overlap / 2;
    turned(wa, a->q, a->w, 1);
    turned(wb, b->q, b->w, 1);
    for (int k = 0; k < 3; k++)
        reach[k] = arm_a * wa[k] + arm_b * wb[k];
    cross(spin, reach, n);
    for (int k = 0; k < 3; k++)
        slip[k] = a->v[k] - b->v[k] - closing * n[k] + spin[k];
    double size = size_of(slip);
    double rub = size > 0 ? e->friction * fmax(force, 0) / size : 0;
    for (int k = 0; k < 3; k++) {
        f[k] = -force * n[k] - rub * slip[k];
        a->f[k] += f[k];
        b->f[k] -= f[k];
    }
    cross(torque, n, f);
    for (int k = 0; k < 3; k++) {
        a->torque[k] += arm_a * torque[k];
        b->torque[k] += arm_b * torque[k];
    }
}

static void forces(void)
{
    for (int i = 0; i < bodies; i++) {
        memset(body[i].f, 0, sizeof body[i].f);
        memset(body[i].torque, 0, sizeof body[i].torque);
    }
    for (struct element *e = element; e < element + elements; e++) {
        if (e->kind == 's')
            spring(e);
        for (int j = 0; e->kind == 'u' && j < 3 * bodies; j++)
            body[j / 3].f[j % 3] += body[j / 3].m * e->end[j % 3];
        for (int j = 1; e->kind == 'c' && j < bodies; j++)
            for (int i = 0; i < j; i++)
                contact(e, &body[i], &body[j]);
    }
}

static void kick(struct body *b, double h)
{
    double torque[3];
    turned(torque, b->q, b->torque, -1);
    for (int k = 0; k < 3; k++) {
        b->v[k] += h * b->f[k] / b->m;
        b->w[k] += b->J[k] > 0 ? h * torque[k] / b->J[k] : 0;
    }
}

static void step(double h)
{
    struct body half[MOST];
    for (struct body *b = body; b < body + bodies; b++) {
        kick(b, h / 2);
        for (int k = 0; k < 3; k++)
            b->r[k] += h * b->v[k];
        for (int i = 0; b->J[0] > 0 && i < 5; i++)
            turn(b->q, b->w, b->J, i < 3 ? i : 4 - i, i == 2 ? h : h / 2);
        made_unit(b->q);
        half[b - body] = *b;
        kick(b, h / 2); /* predicted velocities, for forces that depend on them */
    }
    forces();
    for (struct body *b = body; b < body + bodies; b++) {
        memcpy(b->v, half[b - body].v, sizeof b->v);
        memcpy(b->w, half[b - body].w, sizeof b->w);
        kick(b, h / 2);
    }
}

/* Contacts that the last step has begun or ended are told at its end. */
static void tell(FILE *events, double t)
{
    static int touched[MOST][MOST];
    for (int j = 1; j < bodies; j++)
        for (int i = 0; i < j; i++) {
            double to[3];
            for (int k = 0; k < 3; k++)
                to[k] = body[j].r[k] - body[i].r[k];
            int touches = body[i].radius > 0 && body[j].radius > 0
                          && size_of(to) < body[i].radius + body[j].radius;
            if (touches != touched[i][j])
                fprintf(events, "%.17g,%s,%d\n", t, touches ? "contact" : "release", i);
            touched[i][j] = touches;
        }
}

int main(int argc, char **argv)
{
    if (argc != 4)
        return fprintf(stderr, "usage: dem REQUEST.TXT TRAJECTORY.CSV EVENTS.CSV\n"), 2;
    read_request(argv[1]);
    read_scene();
    FILE *out = fopen(argv[2], "w");
    FILE *events = fopen(argv[3], "w");
    fprintf(events, "time,kind,body\n");
    fprintf(out, "t,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz\n");
    double t0 = atof(text("times.0"));
    double interval = atof(text("times.1")) - t0;
    double w[3];
    long stride = atol(text("stride"));
    long samples = atol(text("times.count"));
    for (int i = 0; i < bodies; i++) {
        turned(w, body[i].q, body[i].w, -1);
        memcpy(body[i].w, w, sizeof w);
    }
    forces();
    for (long n = 0; n < samples; n++) {
        for (long k = 0; n > 0 && k < stride; k++) {
            step(interval / stride);
            tell(events, t0 + (n - 1) * interval + (k + 1) * interval / stride);
        }
        for (int i = 0; i < bodies; i++) {
            struct body *b = &body[i];
            turned(w, b->q, b->w, 1);
            fprintf(out, "%.17g,%d,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,", t0 + n * interval, i,
                    b->r[0], b->r[1], b->r[2], b->v[0], b->v[1], b->v[2]);
            fprintf(out, "%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", b->q[0], b->q[1], b->q[2],
                    b->q[3], w[0], w[1], w[2]);
        }
    }
    return fclose(events) || fclose(out);
}
