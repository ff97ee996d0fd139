/* Velocity Verlet for masses on springs to the world; stays alive: reads a line for each request,
 * answers with a line. Usage: springs, requests on standard input; or springs REQUEST.TXT
 * TRAJECTORY.CSV for one run. */
#include "../c/request.h"
#include <unistd.h>

/* The text of `"name": "text"` in a line of JSON whose strings have no escapes. */
static void word(char *out, size_t size, const char *line, const char *name)
{
    char key[80];
    out[0] = '\0';
    snprintf(key, sizeof key, "\"%s\": \"", name);
    const char *begin = strstr(line, key);
    if (!begin)
        return;
    begin += strlen(key);
    size_t length = strcspn(begin, "\"");
    if (length < size) {
        memcpy(out, begin, length);
        out[length] = '\0';
    }
}

static void forget(void)
{
    for (int i = 0; i < lines; i++) {
        free(keys[i]);
        free(values[i]);
    }
    lines = 0;
}

/* NULL, or why the scene is not supported. */
static const char *solve(const char *request, const char *trajectory)
{
    forget();
    read_request(request);
    if (atoi(text("scene.bodies.count")) != 1 || atof(text("scene.elements.0.length")) != 0)
        return "one mass on one spring of no length";
    const double h = atof(text("step"));
    const double omega2
        = atof(text("scene.elements.0.stiffness")) / atof(text("scene.bodies.0.mass"));
    const double start = atof(text("times.0"));
    const long stride = atol(text("stride"));
    const long samples = atol(text("times.count"));
    double r[3], v[3], anchor[3];
    vector(r, 3, "bodies", 0, "position");
    vector(v, 3, "bodies", 0, "velocity");
    vector(anchor, 3, "elements", 0, "anchor_b");
    FILE *out = fopen(trajectory, "w");
    if (!out)
        return "the trajectory cannot be written";
    fprintf(out, "t,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz\n");
    for (long n = 0; n < samples; n++) {
        for (long step = 0; n > 0 && step < stride; step++)
            for (int i = 0; i < 3; i++) {
                v[i] -= h / 2 * omega2 * (r[i] - anchor[i]);
                r[i] += h * v[i];
                v[i] -= h / 2 * omega2 * (r[i] - anchor[i]);
            }
        fprintf(out, "%.17g,0,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,,,,,,,\n", start + n * stride * h,
                r[0], r[1], r[2], v[0], v[1], v[2]);
    }
    fclose(out);
    return NULL;
}

int main(int argc, char **argv)
{
    static char line[8192], id[80], request[4096], trajectory[4096];
    if (argc == 3) {
        const char *why = solve(argv[1], argv[2]);
        if (why)
            unsupported(why);
        return 0;
    }
    /* Answers have a stream of their own: whatever else is printed goes to standard error. */
    FILE *answers = fdopen(dup(1), "w");
    dup2(2, 1);
    printf("a banner, as many libraries print one\n");
    fprintf(answers, "{\"ready\": true}\n");
    fflush(answers);
    while (fgets(line, sizeof line, stdin)) {
        word(id, sizeof id, line, "id");
        word(request, sizeof request, line, "request_txt");
        word(trajectory, sizeof trajectory, line, "trajectory");
        const char *why = solve(request, trajectory);
        if (why)
            fprintf(answers, "{\"id\": \"%s\", \"unsupported\": \"%s\"}\n", id, why);
        else
            fprintf(answers, "{\"id\": \"%s\", \"done\": true}\n", id);
        fflush(answers);
    }
    return 0;
}
