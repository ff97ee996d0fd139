"""The operations of algebra that an Identity may request, with the sizes of their operands and of
their result: rotations, degrees of freedom, bifurcations, Poincare sections.

Matrices (9) are row by row and map body vectors to space; quaternions (4) are (w, x, y, z); angles
are in radians. Numbers in brackets are the equations of the source chapter.
"""

# Operation: ((numbers of each operand), numbers of the result); 0 is any size.
SIZES: dict[str, tuple[tuple[int, ...], int]] = {
    "sum": ((4, 4), 4),
    "dot": ((4, 4), 1),
    "difference": ((4, 4), 4),
    "quotient": ((1, 1), 1),
    "scalar-sum": ((1, 1), 1),
    "vector-sum": ((3, 3), 3),
    "vector-difference": ((3, 3), 3),
    "vector-dot": ((3, 3), 1),
    "cross": ((3, 3), 3),
    "cross-square": ((3, 3), 1),  # |v|^2 |w|^2 - (v . w)^2, which is |v x w|^2
    "rejection": ((3, 3), 3),  # a - (a . b) b/b^2, the part of a across b
    "length": ((3,), 1),
    "plane-turn": ((1, 2), 2),  # angle, vector: by the matrix (1.9)
    "complex-turn": ((1, 2), 2),  # angle, vector: by exp(i angle)
    # angle: real part and imaginary part >= 0 of an eigenvalue of the matrix (1.9)
    "plane-eigenvalue": ((1,), 2),
    "plane-determinant": ((1,), 1),
    "mirror": ((1, 2), 2),  # angle, vector: mirrored at the line with that angle to x
    "mirror-determinant": ((1,), 1),
    # angle, n: cos(n angle) from sine and cosine of the angle
    "cosine-by-recurrence": ((1, 1), 1),
    "cosine-by-powers": ((1, 1), 1),
    # angles a, b: cos a cos b, and the same as (cos(a - b) + cos(a + b))/2
    "cosine-product": ((1, 1), 1),
    "cosines-mixed": ((1, 1), 1),
    "turn-about": ((3, 1), 9),  # unit vector, angle
    "matrix-product": ((9, 9), 9),
    "matrix-difference": ((9, 9), 9),
    "matrix-vector": ((9, 3), 3),
    "transpose": ((9,), 9),
    "determinant": ((9,), 1),
    "turn-angle": ((9,), 1),  # in [0, pi]
    "first-order-turn": ((9, 3), 9),  # (1 + [v]) M for a rotation vector v, [v] r = v x r
    "orthogonality": ((9,), 9),  # M^T M - 1
    "nearest-turn": ((9,), 9),  # the rotation matrix nearest to M
    # dimension of the space of rates of the nine entries that keep M^T M
    "orthogonal-freedom": ((9,), 1),
    "quaternion-about": ((3, 1), 4),  # unit vector, angle
    "product": ((4, 4), 4),
    "real-product": ((4, 4), 4),  # by the real matrix 4 x 4 of the first
    "complex-product": ((4, 4), 4),  # by the complex matrices 2 x 2 of both
    # real part and imaginary part >= 0 of an eigenvalue of the complex matrix 2 x 2
    "complex-eigenvalue": ((4,), 2),
    # the eigenvalues, larger first, of x s1 + y s2 + z s3 with Pauli's matrices (1.143)
    "pauli-eigenvalues": ((3,), 2),
    "conjugate": ((4,), 4),
    "inverse": ((4,), 4),
    "absolute": ((4,), 1),
    "unit": ((4,), 4),
    "negative": ((4,), 4),
    "rotated": ((4, 3), 3),  # q v q* for the unit quaternion q
    "matrix-of-quaternion": ((4,), 9),
    "quaternion-of-matrix": ((9,), 4),  # w >= 0
    "matrix-of-euler": ((3,), 9),  # phi, theta, psi of z-x-z
    "quaternion-of-euler": ((3,), 4),
    "euler-of-matrix": ((9,), 3),  # theta in [0, pi]
    "euler-rates": ((3, 3), 3),  # Euler angles, omega in space axes
    # Euler angles: the matrix that takes their rates to omega in space axes, and its inverse in
    # angles (1.39) to (1.41)
    "euler-rate-matrix": ((3,), 9),
    "euler-rate-inverse": ((3,), 9),
    "rate": ((4, 3), 4),  # q' for omega in space axes (1.67)
    "second-rate": ((4, 3, 3), 4),  # q'' for omega and its derivative (1.68)
    "omega-of-rate": ((4, 4), 3),  # 2 q' q* (1.89)
    "body-omega-of-rate": ((4, 4), 3),  # 2 q* q' (1.90)
    "rotation-energy": ((1, 1), 1),  # J omega^2/2
    "spin-momentum": ((1, 1), 1),  # L = J omega about a principal axis
    "momentum-energy": ((1, 1), 1),  # L, J: L^2/(2 J)
    "principal-moments": ((9,), 3),  # the eigenvalues of a tensor of inertia, in rising order
    # masses, velocities point by point: kinetic energy, that of the centre of mass, that about it
    "points-energy": ((0, 0), 1),
    "centre-energy": ((0, 0), 1),
    "energy-about-centre": ((0, 0), 1),
    # masses, positions, velocities point by point: the same for angular momentum about the origin
    "points-angular-momentum": ((0, 0, 0), 3),
    "centre-angular-momentum": ((0, 0, 0), 3),
    "angular-momentum-about-centre": ((0, 0, 0), 3),
    # masses, positions point by point, omega: sum m |omega x r|^2/2, and omega . J omega/2
    "swept-energy": ((0, 0, 3), 1),
    "tensor-energy": ((0, 0, 3), 1),
    # dimension, coordinates point by point, rods as pairs of point numbers: dimension of the space
    # of velocities that keep every rod's length to first order
    "first-order-freedom": ((1, 0, 0), 1),
    # dimension, coordinates: number of independent motions that keep every distance
    "rigid-freedom": ((1, 0), 1),
    # amplitude, (alpha, beta, delta), f0: lower and higher drive of harmonic balance (1.121)
    "balanced-drives": ((1, 3, 1), 2),
    # amplitude, (alpha, beta, delta), drives: the force that each of them needs (1.120)
    "balanced-forces": ((1, 3, 2), 2),
    # (alpha, beta, delta), f0: drive and amplitude at which harmonic balance folds (1.120)
    "lower-fold": ((3, 1), 2),
    "upper-fold": ((3, 1), 2),
    # eta > 3: the iterates, larger first, between which the logistic map alternates (1.127)
    "two-cycle": ((1,), 2),
    # x: the share of the iterates of the map at eta = 4 that are below x
    "share-below": ((1,), 1),
    # n = 0, 1, 2: the eta at which the map's cycle of 2^n iterates doubles its period
    "doubling-point": ((1,), 1),
    # Of a unit mass on a unit spring that rubs on a belt (1.125): (a, mu0, mu1, lambda0, lambda1),
    # the power of the last term of mu, (belt, gamma, eta), (x, v) at the start, n: place and
    # velocity after n periods of the drive; time and place of the n-th passage of v = 0, x > 0
    "belt-strobe": ((5, 1, 3, 2, 1), 2),
    "belt-passage": ((5, 1, 3, 2, 1), 2),
}

COUNTING_OPERANDS: dict[str, tuple[int, ...]] = {
    "first-order-freedom": (0, 2),
    "rigid-freedom": (0,),
    "cosine-by-recurrence": (1,),
    "cosine-by-powers": (1,),
    "doubling-point": (0,),
    "belt-strobe": (1, 4),
    "belt-passage": (1, 4),
}
"""Places of the operands that count or name something (a dimension, points of a rod, a multiple)
instead of measuring it: they have no last digit that a rounding could move.
"""
