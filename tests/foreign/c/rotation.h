/* Vectors and turns. Quaternions are (w, x, y, z) and take body to space axes. */
#include <math.h>

/* A vector turned from body to space axes (way = 1) or back (way = -1). */
static void turned(double *out, const double *q, const double *a, int way)
{
    double w = q[0];
    double x = way * q[1];
    double y = way * q[2];
    double z = way * q[3];
    double t[3] = {2 * (y * a[2] - z * a[1]), 2 * (z * a[0] - x * a[2]), 2 * (x * a[1] - y * a[0])};
    double u[3] = {y * t[2] - z * t[1], z * t[0] - x * t[2], x * t[1] - y * t[0]};
    for (int k = 0; k < 3; k++)
        out[k] = a[k] + w * t[k] + u[k];
}

static void cross(double *out, const double *a, const double *b)
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static double size_of(const double *a)
{
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

/* A force-free turn about principal axis i: the angular momentum turns the other way in body axes.
 */
static void turn(double *q, double *w, const double *J, int i, double h)
{
    int j = (i + 1) % 3;
    int k = (i + 2) % 3;
    double angle = h * w[i];
    double c = cos(angle / 2);
    double s = sin(angle / 2);
    double u = q[0];
    double x = q[1 + i];
    double y = q[1 + j];
    double z = q[1 + k];
    double lj = J[j] * w[j];
    double lk = J[k] * w[k];
    w[j] = (lj * cos(angle) + lk * sin(angle)) / J[j];
    w[k] = (lk * cos(angle) - lj * sin(angle)) / J[k];
    q[0] = c * u - s * x;
    q[1 + i] = c * x + s * u;
    q[1 + j] = c * y + s * z;
    q[1 + k] = c * z - s * y;
}

/* Rounding of the same turn again and again adds up: the norm would drift with the number of steps.
 */
static void made_unit(double *q)
{
    double norm = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 4; k++)
        q[k] /= norm;
}
