/* Bodies and elements of a request, and the rows of the answer, for all programs of this folder.
 *
 * Switches of the compiler: SINGLE (float in place of double), SIGNS (attitudes of either sign in
 * the answer), COMPENSATED (Kahan's sums), COUNTER32 (a step counter of 32 bits), TWO_WRITERS (two
 * threads write the rows as text). */
#include <pthread.h>
#include <setjmp.h>
#include <stdint.h>
#include <tgmath.h>

#include "../c/request.h"

#ifdef SINGLE
typedef float real;
#else
typedef double real;
#endif

#ifdef COUNTER32
typedef uint32_t counter;
#else
typedef uint64_t counter;
#endif

enum { MOST = 32 };

struct body {
    real m, J[3], r[3], v[3], q[4], w[3]; /* w in space axes */
    real radius;
    real f[3], torque[3];
    real lost_r[3], lost_v[3]; /* what Kahan's sums still have to add */
};

struct element {
    char kind[24], law[16], branch[16], cutoff[16];
    int a, b;
    real end[3]; /* anchor in the world, direction of gravity, point of a plane */
    real axis[3];
    real k, n, quadratic, cubic, length, damping, van_der_pol, friction, normal_force;
    real amplitude, frequency, phase, coefficient, gm, restitution, slip_restitution;
    real mu0, mu1, lambda0, lambda1, belt, k1, k2, x1, x2, box_size;
    int touched[MOST][MOST + 1];
};

static struct body body[MOST];
static struct element element[MOST];
static int bodies, elements;
static jmp_buf refusing;
static const char *refusal;

/* Ends the request: the scene is not supported. */
static void refuse(const char *why)
{
    refusal = why;
    longjmp(refusing, 1);
}

static void reals(real *out, int n, const char *what, int i, const char *name)
{
    for (int k = 0; k < n; k++)
        out[k] = (real)atof(text("scene.%s.%d.%s.%d", what, i, name, k));
}

static real number(const char *name, int i)
{
    return (real)atof(text("scene.elements.%d.%s", i, name));
}

static void word(char *out, size_t size, const char *name, int i)
{
    snprintf(out, size, "%s", text("scene.elements.%d.%s", i, name));
}

static inline int is_kind(const struct element *e, const char *kind)
{
    return strcmp(e->kind, kind) == 0;
}

static inline int is_law(const struct element *e, const char *law)
{
    return strcmp(e->law, law) == 0;
}

static inline real dot(const real *a, const real *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline real size_of(const real *a)
{
    return sqrt(dot(a, a));
}

static inline void cross(real *out, const real *a, const real *b)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static inline void unit_quaternion(real *q)
{
    const real size = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 4; k++)
        q[k] /= size;
}

/* The product a b of quaternions (w, x, y, z). */
static inline void product(real *out, const real *a, const real *b)
{
    const real w = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    const real x = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    const real y = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    const real z = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
    out[0] = w;
    out[1] = x;
    out[2] = y;
    out[3] = z;
}

/* The attitude after a turn with the angular velocity w in space axes during h: exp(h w/2) q. */
static inline void turn_in_space(real *q, const real *w, real h)
{
    const real speed = size_of(w);
    if (speed == 0)
        return;
    const real angle = h * speed;
    const real s = sin(angle / 2) / speed;
    const real turn[4] = {cos(angle / 2), s * w[0], s * w[1], s * w[2]};
    product(q, turn, q);
    unit_quaternion(q);
}

static inline int is_isotropic(const struct body *b)
{
    return b->J[0] == b->J[1] && b->J[1] == b->J[2];
}

/* Only links between centres are known in this folder: an anchor elsewhere makes a torque. */
static int is_off_centre(int i, const char *anchor)
{
    real at[3];
    reals(at, 3, "elements", i, anchor);
    return at[0] != 0 || at[1] != 0 || at[2] != 0;
}

static void read_element(struct element *e, int i)
{
    memset(e, 0, sizeof *e);
    word(e->kind, sizeof e->kind, "kind", i);
    word(e->law, sizeof e->law, "law", i);
    word(e->branch, sizeof e->branch, "branch", i);
    word(e->cutoff, sizeof e->cutoff, "cutoff", i);
    e->a = (int)number("a", i);
    e->b = (int)number("b", i);
    e->k = number("stiffness", i);
    e->n = number("exponent", i);
    e->quadratic = number("quadratic", i);
    e->cubic = number("cubic", i);
    e->length = number("length", i);
    e->damping = number("damping", i);
    e->van_der_pol = number("van_der_pol", i);
    e->friction = number("friction", i);
    e->normal_force = number("normal_force", i);
    e->amplitude = number("amplitude", i);
    e->frequency = number("frequency", i);
    e->phase = number("phase", i);
    e->coefficient = number("coefficient", i);
    e->gm = number("gm", i);
    e->restitution = number("restitution", i);
    e->slip_restitution = number("tangential_restitution", i);
    e->mu0 = number("mu0", i);
    e->mu1 = number("mu1", i);
    e->lambda0 = number("lambda0", i);
    e->lambda1 = number("lambda1", i);
    e->belt = number("belt_velocity", i);
    e->k1 = number("k1", i);
    e->k2 = number("k2", i);
    e->x1 = number("x1", i);
    e->x2 = number("x2", i);
    e->box_size = number("size", i);
    reals(e->axis, 3, "elements", i, is_kind(e, "plane") ? "normal" : "axis");
    const char *end = "anchor_b";
    if (is_kind(e, "uniform_gravity"))
        end = "g";
    else if (is_kind(e, "plane") || is_kind(e, "piecewise_field"))
        end = "point";
    reals(e->end, 3, "elements", i, end);
    if (is_off_centre(i, "anchor_a") || (e->b >= 0 && is_off_centre(i, "anchor_b")))
        refuse("anchors off the centre");
    if (number("tangential_stiffness", i) > 0)
        refuse("tangential springs");
}

static void read_scene(void)
{
    bodies = atoi(text("scene.bodies.count"));
    elements = atoi(text("scene.elements.count"));
    if (bodies > MOST || elements > MOST)
        refuse("more than 32 bodies or elements");
    memset(body, 0, sizeof body);
    for (int i = 0; i < bodies; i++) {
        struct body *b = &body[i];
        b->m = (real)atof(text("scene.bodies.%d.mass", i));
        b->radius = (real)atof(text("scene.bodies.%d.shape.radius", i));
        reals(b->J, 3, "bodies", i, "inertia");
        reals(b->r, 3, "bodies", i, "position");
        reals(b->v, 3, "bodies", i, "velocity");
        reals(b->q, 4, "bodies", i, "attitude");
        reals(b->w, 3, "bodies", i, "omega");
        if (strcmp(text("scene.bodies.%d.shape.kind", i), "polyhedron") == 0)
            refuse("polyhedra");
    }
    for (int i = 0; i < elements; i++)
        read_element(&element[i], i);
}

/* Rows of the answer, kept until the end of the run. */
enum { COLUMNS = 15, ROW_BYTES = 512 };
static double (*row)[COLUMNS];
static size_t rows, room;

static void add_row(double t, int i, const struct body *b)
{
    if (rows == room) {
        room = 2 * room + 1024;
        row = realloc(row, room * sizeof *row);
        if (!row)
            exit(3);
    }
    double *to = row[rows++];
    *to++ = t;
    *to++ = i;
    for (int k = 0; k < 3; k++)
        *to++ = b->r[k];
    for (int k = 0; k < 3; k++)
        *to++ = b->v[k];
    double sign = 1.0;
#ifdef SIGNS
    /* The attitudes q and -q are the same: this program writes either, as if at random. */
    static uint64_t state;
    state = rows == 1 ? 88172645463325252u : state;
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    sign = state & 1 ? 1.0 : -1.0;
#endif
    for (int k = 0; k < 4; k++)
        *to++ = sign * b->q[k];
    for (int k = 0; k < 3; k++)
        *to++ = b->w[k];
}

static void add_sample(double t)
{
    for (int i = 0; i < bodies; i++)
        add_row(t, i, &body[i]);
}

/* What is asked for: samples `interval` apart, with `stride` steps of length h from each to the
 * next. */
struct schedule {
    double start, interval, h;
    counter stride, samples;
};

static struct schedule asked_schedule(void)
{
    struct schedule s;
    s.start = atof(text("times.0"));
    s.interval = atof(text("times.1")) - s.start;
    s.stride = (counter)atol(text("stride"));
    s.samples = (counter)atol(text("times.count"));
    s.h = s.interval / (double)s.stride;
    return s;
}

/* Takes all steps, each from its time t, and keeps the samples. Steps are counted, times never
 * compared. `after`, if not NULL, is called at the end of every step. */
static void march(const struct schedule *s, void (*step)(double t, real h), void (*after)(double t))
{
    add_sample(s->start);
    const counter steps = s->stride * (s->samples - 1);
    for (counter n = 0; n < steps; n++) {
        step(s->start + (double)n * s->h, (real)s->h);
        if (after)
            after(s->start + (double)(n + 1) * s->h);
        if ((n + 1) % s->stride == 0)
            add_sample(s->start + (double)((n + 1) / s->stride) * s->interval);
    }
}

/* The text of some of the rows. */
struct part {
    size_t begin, end;
    char *text;
};

static void *written(void *argument)
{
    struct part *part = argument;
    part->text = malloc((part->end - part->begin) * ROW_BYTES + 1);
    if (!part->text)
        exit(3);
    char *to = part->text;
    *to = '\0';
    for (size_t i = part->begin; i < part->end; i++) {
        to += sprintf(to, "%.17g,%d", row[i][0], (int)row[i][1]);
        for (int k = 2; k < COLUMNS; k++)
            to += sprintf(to, ",%.17g", row[i][k]);
        to += sprintf(to, "\n");
    }
    return NULL;
}

static int write_rows(const char *path)
{
    FILE *out = fopen(path, "w");
    if (!out)
        return 1;
    fprintf(out, "t,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz\n");
#ifdef TWO_WRITERS
    struct part part[2] = {{0, rows / 2, NULL}, {rows / 2, rows, NULL}};
    pthread_t thread[2];
    for (int i = 0; i < 2; i++)
        if (pthread_create(&thread[i], NULL, written, &part[i]))
            return 1;
    for (int i = 0; i < 2; i++)
        pthread_join(thread[i], NULL);
    for (int i = 0; i < 2; i++) {
        fputs(part[i].text, out);
        free(part[i].text);
    }
#else
    struct part part = {0, rows, NULL};
    written(&part);
    fputs(part.text, out);
    free(part.text);
#endif
    return fclose(out);
}

/* One request: a program that includes this file defines it. */
static void solve(const char *method);
static FILE *events;

static inline void event(double t, const char *kind, int i)
{
    if (events)
        fprintf(events, "%.17g,%s,%d\n", t, kind, i);
}

/* NULL, or why the scene is not supported. */
static const char *answer(const char *request, const char *trajectory, const char *event_path)
{
    for (int i = 0; i < lines; i++) {
        free(keys[i]);
        free(values[i]);
    }
    lines = 0;
    rows = 0;
    events = NULL;
    if (setjmp(refusing)) {
        if (events)
            fclose(events);
        return refusal;
    }
    read_request(request);
    read_scene();
    if (event_path) {
        events = fopen(event_path, "w");
        if (events)
            fprintf(events, "time,kind,body\n");
    }
    solve(text("method"));
    if (events)
        fclose(events);
    if (write_rows(trajectory))
        exit(3);
    return NULL;
}

/* The text of `"name": "text"` in a line of JSON whose strings have no escapes. */
static void said(char *out, size_t size, const char *line, const char *name)
{
    char key[80];
    snprintf(key, sizeof key, "\"%s\": \"", name);
    out[0] = '\0';
    const char *begin = strstr(line, key);
    if (!begin)
        return;
    begin += strlen(key);
    const size_t length = strcspn(begin, "\"");
    if (length < size) {
        memcpy(out, begin, length);
        out[length] = '\0';
    }
}

static int serve(void)
{
    static char line[16384], id[80], request[4096], trajectory[4096], event_path[4096];
    printf("{\"ready\": true}\n");
    fflush(stdout);
    while (fgets(line, sizeof line, stdin)) {
        said(id, sizeof id, line, "id");
        said(request, sizeof request, line, "request_txt");
        said(trajectory, sizeof trajectory, line, "trajectory");
        said(event_path, sizeof event_path, line, "events");
        const char *why = answer(request, trajectory, event_path[0] ? event_path : NULL);
        if (why)
            printf("{\"id\": \"%s\", \"unsupported\": \"%s\"}\n", id, why);
        else
            printf("{\"id\": \"%s\", \"done\": true}\n", id);
        fflush(stdout);
    }
    return 0;
}

/* Usage: PROGRAM REQUEST.TXT TRAJECTORY.CSV [EVENTS.CSV], or without arguments to stay alive. */
int main(int argc, char **argv)
{
    if (argc == 1)
        return serve();
    if (argc < 3)
        return 2;
    const char *why = answer(argv[1], argv[2], argc > 3 ? argv[3] : NULL);
    if (why)
        unsupported(why);
    return 0;
}
