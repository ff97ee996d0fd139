/* Reads certified values from C: the period of the pendulum, against Gauss's arithmetic-geometric
 * mean.
 *
 *   cc -std=c11 certified.c -lm -o certified && ./certified
 * validation/truth/certified/pendulum.jsonl
 *
 * A file of certified values is one JSON value a line. A set is an object with its parameters; its
 * values follow as arrays [t, quantity, mid, radius, binary64]; binary64 is a C99 hexadecimal
 * floating constant, null where the rounding is not sure. All of them are texts, and no text holds
 * a quotation mark, so that texts between quotation marks are all that a reader needs.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LONGEST = 1 << 16, MOST = 64 };

/* The texts between quotation marks of a line, ended in place; how many there are, at most `most`.
 */
static int texts(char *line, char *found[], int most)
{
    int count = 0;
    for (char *at = strchr(line, '"'); at && count < most; at = strchr(at + 1, '"')) {
        found[count++] = at + 1;
        at = strchr(at + 1, '"');
        if (!at)
            break;
        *at = '\0';
    }
    return count;
}

/* The number of "3/2" or "0.5". */
static double number(const char *text)
{
    char *rest;
    double value = strtod(text, &rest);
    return *rest == '/' ? value / strtod(rest + 1, NULL) : value;
}

/* The parameter `name` of a set's texts; ends the program if it is not there. */
static double parameter(char *found[], int count, const char *name)
{
    for (int i = 0; i + 1 < count; i++)
        if (strcmp(found[i], name) == 0)
            return number(found[i + 1]);
    fprintf(stderr, "no parameter %s\n", name);
    exit(2);
}

/* Period [s] of a pendulum that swings from rest at theta0: 2 pi/w0 over the mean of 1 and
 * cos(theta0/2). */
static double period(double length, double gravity, double theta0)
{
    double a = 1.0, b = cos(theta0 / 2);
    for (int i = 0; i < 8; i++) {
        double mean = (a + b) / 2;
        b = sqrt(a * b);
        a = mean;
    }
    return 2 * acos(-1.0) * sqrt(length / gravity) / a;
}

int main(int argc, char **argv)
{
    static char line[LONGEST], copy[LONGEST];
    FILE *file = argc == 2 ? fopen(argv[1], "r") : NULL;
    if (!file)
        return fprintf(stderr, "usage: %s pendulum.jsonl\n", argv[0]), 2;
    double length = 0, gravity = 0, theta0 = 0, thetadot0 = 1, worst = 0;
    int compared = 0;
    while (fgets(line, LONGEST, file)) {
        char *found[MOST];
        memcpy(copy, line, sizeof copy);
        int count = texts(copy, found, MOST);
        if (line[0] == '{' && count > 2 && strcmp(found[0], "set") == 0) {
            length = parameter(found, count, "length");
            gravity = parameter(found, count, "gravity");
            theta0 = parameter(found, count, "theta0");
            thetadot0 = parameter(found, count, "thetadot0");
        } else if (strncmp(line, "[null,\"period\"", 14) == 0 && count == 4 && thetadot0 == 0) {
            double certified = strtod(found[3], NULL), mine = period(length, gravity, theta0);
            printf("theta0 = %-6g period %s +- %s s; by the mean %.17g\n", theta0, found[1],
                   found[2], mine);
            worst = fmax(worst, fabs(mine - certified) / certified);
            compared++;
        }
    }
    fclose(file);
    printf("%d periods, relative difference at most %.2g\n", compared, worst);
    return compared && worst < 1e-15 ? 0 : 1;
}
