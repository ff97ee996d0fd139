/* Reads request.txt, lines of `key value`: copy it into your own program. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LINES = 400000 };
static char *keys[LINES], *values[LINES];
static int lines;

static void read_request(const char *path)
{
    char key[200], value[200];
    FILE *file = fopen(path, "r");
    if (!file) {
        perror(path);
        exit(2);
    }
    while (lines < LINES && fscanf(file, "%199s %199s", key, value) == 2) {
        keys[lines] = strdup(key);
        values[lines++] = strdup(value);
    }
    fclose(file);
}

/* The value of a key whose name is put together as by printf; "" if it is not there. */
static const char *text(const char *format, ...)
{
    char key[200];
    va_list rest;
    va_start(rest, format);
    vsnprintf(key, sizeof key, format, rest);
    va_end(rest);
    for (int i = 0; i < lines; i++)
        if (strcmp(keys[i], key) == 0)
            return values[i];
    return "";
}

/* n numbers `scene.WHAT.I.NAME.0`, `.1` and so on; zeros where there are none. */
static inline void vector(double *out, int n, const char *what, int i, const char *name)
{
    for (int k = 0; k < n; k++)
        out[k] = atof(text("scene.%s.%d.%s.%d", what, i, name, k));
}

/* Exit status 77 says "not supported"; the last line on stderr says why. */
static void unsupported(const char *why)
{
    fprintf(stderr, "%s\n", why);
    exit(77);
}
