/* Mass properties of polyhedra, by tetrahedra from the origin to the triangles of each face. Usage:
 * moments REQUEST.TXT ANSWER.CSV For a tetrahedron 0abc with det = a.(b x c) and s = a + b + c: V =
 * det/6, integral of x = det/24 s, integral of x_i x_j = det/120 (s_i s_j + a_i a_j + b_i b_j + c_i
 * c_j). Other shapes get rows without numbers. */
#include <math.h>

#include "../c/request.h"

enum { MOST = 512 };
struct sums {
    double volume, first[3], second[3][3];
};

/* Adds `sign` times the integrals of the polyhedron request.problem.solids.I.NAME; 0 if it is no
 * polyhedron. */
static int added(struct sums *to, int i, const char *name, double sign)
{
    static double v[MOST][3];
    if (strcmp(text("problem.solids.%d.%s.kind", i, name), "polyhedron"))
        return 0;
    int vertices = atoi(text("problem.solids.%d.%s.vertices.count", i, name));
    int faces = atoi(text("problem.solids.%d.%s.faces.count", i, name));
    if (vertices > MOST)
        unsupported("more than 512 vertices");
    for (int n = 0; n < 3 * vertices; n++)
        v[n / 3][n % 3] = atof(text("problem.solids.%d.%s.vertices.%d.%d", i, name, n / 3, n % 3));
    for (int f = 0; f < faces; f++) {
        int corners = atoi(text("problem.solids.%d.%s.faces.%d.count", i, name, f));
        int at[MOST];
        for (int k = 0; k < corners; k++)
            at[k] = atoi(text("problem.solids.%d.%s.faces.%d.%d", i, name, f, k));
        for (int k = 1; k + 1 < corners; k++) {
            const double *a = v[at[0]];
            const double *b = v[at[k]];
            const double *c = v[at[k + 1]];
            double det = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
                         + a[2] * (b[0] * c[1] - b[1] * c[0]);
            to->volume += sign * det / 6;
            for (int m = 0; m < 3; m++) {
                to->first[m] += sign * det / 24 * (a[m] + b[m] + c[m]);
                for (int n = 0; n < 3; n++) {
                    double s = (a[m] + b[m] + c[m]) * (a[n] + b[n] + c[n]);
                    to->second[m][n]
                        += sign * det / 120 * (s + a[m] * a[n] + b[m] * b[n] + c[m] * c[n]);
                }
            }
        }
    }
    return 1;
}

/* The rotation matrix of the solid's attitude, a quaternion of any length. */
static void rotation(double R[3][3], int i)
{
    double q[4];
    double size = 0;
    for (int k = 0; k < 4; k++) {
        q[k] = atof(text("problem.solids.%d.attitude.%d", i, k));
        size += q[k] * q[k];
    }
    for (int k = 0; k < 4; k++)
        q[k] /= sqrt(size);
    double w = q[0];
    double x = q[1];
    double y = q[2];
    double z = q[3];
    double rows[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                         {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                         {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    memcpy(R, rows, sizeof rows);
}

/* to = R S R^T */
static void turned(double to[3][3], double R[3][3], double S[3][3])
{
    for (int m = 0; m < 3; m++)
        for (int n = 0; n < 3; n++) {
            to[m][n] = 0;
            for (int k = 0; k < 3; k++)
                for (int l = 0; l < 3; l++)
                    to[m][n] += R[m][k] * S[k][l] * R[n][l];
        }
}

static void answer(FILE *out, int i)
{
    struct sums sums = {0};
    double R[3][3], S[3][3];
    double centre[3] = {0};
    double shift[3] = {0};
    double density = atof(text("problem.solids.%d.density", i));
    int known = added(&sums, i, "shape", 1)
                && (!*text("problem.solids.%d.hollow.kind", i) || added(&sums, i, "hollow", -1));
    fprintf(out, "%s", text("problem.solids.%d.name", i));
    if (!known) {
        fprintf(out, ",,,,,,,,,,\n");
        return;
    }
    double mass = density * sums.volume;
    double trace = 0;
    rotation(R, i);
    for (int m = 0; m < 3; m++)
        for (int n = 0; n < 3; n++) {
            centre[m] += R[m][n] * sums.first[n] / sums.volume;
            sums.second[m][n] -= sums.first[m] * sums.first[n] / sums.volume;
        }
    turned(S, R, sums.second);
    for (int k = 0; k < 3 && *text("problem.solids.%d.about.0", i); k++)
        shift[k] = atof(text("problem.solids.%d.about.%d", i, k)) - centre[k];
    for (int m = 0; m < 3; m++)
        for (int n = 0; n < 3; n++)
            S[m][n] = density * S[m][n] + mass * shift[m] * shift[n];
    for (int k = 0; k < 3; k++)
        trace += S[k][k];
    fprintf(out, ",%.17g,%.17g,%.17g,%.17g", mass, centre[0], centre[1], centre[2]);
    fprintf(out, ",%.17g,%.17g,%.17g", trace - S[0][0], trace - S[1][1], trace - S[2][2]);
    fprintf(out, ",%.17g,%.17g,%.17g\n", -S[0][1], -S[0][2], -S[1][2]);
}

int main(int argc, char **argv)
{
    if (argc != 3)
        return fprintf(stderr, "usage: moments REQUEST.TXT ANSWER.CSV\n"), 2;
    read_request(argv[1]);
    if (strcmp(text("problem.kind"), "solid"))
        unsupported("questions other than mass properties");
    FILE *out = fopen(argv[2], "w");
    fprintf(out, "solid,mass,x,y,z,xx,yy,zz,xy,xz,yz\n");
    for (int i = 0; i < atoi(text("problem.solids.count")); i++)
        answer(out, i);
    return fclose(out);
}
