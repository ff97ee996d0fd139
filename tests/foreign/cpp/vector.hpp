// Vectors of three numbers.
#include <array>

using Vector = std::array<double, 3>;

inline Vector operator+(Vector a, Vector b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vector operator*(double s, Vector a) { return {s * a[0], s * a[1], s * a[2]}; }
inline Vector operator-(Vector a, Vector b) { return a + -1.0 * b; }
inline double dot(Vector a, Vector b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vector cross(Vector a, Vector b) { return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}; }
