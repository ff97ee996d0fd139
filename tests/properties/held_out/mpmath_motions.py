"""Motions for by_mpmath.py: oscillators, pendulums, rigid bodies, each by its equation of
motion.
"""

from mpmath import (
    acos,
    atan2,
    beta,
    cos,
    ellipfun,
    ellipk,
    exp,
    matrix,
    mp,
    mpc,
    mpf,
    pi,
    sin,
    sqrt,
)

from tests.properties.held_out.mpmath_tools import case, f, ode, second, swung, waves


def oscillators():
    """On a line."""
    w = sqrt(f("3") / 2)
    t = f("7/3")
    case(
        "harmonic-oscillator",
        {"mass": "2", "stiffness": "3", "x0": "-1/3", "v0": "5/7"},
        "7/3",
        x=-cos(w * t) / 3 + f("5/7") / w * sin(w * t),
        v=w * sin(w * t) / 3 + f("5/7") * cos(w * t),
    )
    d = f("1/5")
    r = sqrt(f("7/2") - f("1/25"))
    b = (f("1/3") + d * f("2/7")) / r
    case(
        "viscous-oscillator",
        {"stiffness": "7/2", "delta": "1/5", "x0": "2/7", "v0": "1/3"},
        "13/8",
        x=exp(-d * f("13/8")) * (f("2/7") * cos(r * f("13/8")) + b * sin(r * f("13/8"))),
    )
    case(
        "driven-oscillator",
        {"stiffness": "2", "delta": "3/10", "f0": "5/4", "drive": "7/9"},
        "3/2",
        **second(lambda x, v, c: f("5/4") * c - f("3/5") * v - 2 * x, 1, 0, f("3/2"), f("7/9")),
    )
    case(
        "driven-duffing",
        {"delta": "1/7", "f0": "6/5", "drive": "9/7"},
        "5/4",
        **second(
            lambda x, v, c: f("6/5") * c - f("2/7") * v - x - f("2/5") * x**3,
            1,
            0,
            f("5/4"),
            f("9/7"),
        ),
    )
    case(
        "quadratic-response",
        {"eps": "1/6", "delta": "1/9", "f0": "1/4,1/7"},
        "5/4",
        **second(
            lambda x, v, c, d: c / 4 + d / 7 - f("2/9") * v - x - x * x / 6,
            1,
            0,
            f("5/4"),
            f("3/10"),
            f("1/2"),
        ),
    )
    # The roots of 3 q^2 + (2/7 + 5/9) q + 7 - i 5/9 4.
    damping = f("2/7") + f("5/9")
    half_gap = sqrt(damping**2 - 12 * (7 - mpc(0, 20) / 9)) / 6
    fast = -damping / 6 - half_gap
    slow = -damping / 6 + half_gap
    z0 = mpc(f("1/3"), -1)
    v0 = mpc(2, f("1/5"))
    part = (v0 - fast * z0) / (slow - fast)
    rest = z0 - part
    t = f("7/4")
    z = part * exp(slow * t) + rest * exp(fast * t)
    v = slow * part * exp(slow * t) + fast * rest * exp(fast * t)
    case(
        "whirling-shaft",
        {
            **{"mass": "3", "stiffness": "7", "outer_damping": "2/7", "inner_damping": "5/9"},
            **{"turning": "4", "x0": "1/3,-1", "v0": "2,1/5"},
        },
        "7/4",
        x=z.real,
        y=z.imag,
        vx=v.real,
        vy=v.imag,
    )
    start, turn = waves(f("23/20"))

    def rates(s, y):
        return [
            y[1],
            f("3/7") * (1 - y[0] * y[0]) * y[1] - y[0] + y[3] / 9,
            *turn(y[2:]),
        ]

    found = ode(rates, (f("5/4"), 0, *start), f("5/4"))
    case("van-der-pol", {"mu": "3/7", "p": "1/9", "x0": "5/4"}, "5/4", x=found[0], v=found[1])

    def convection(s, y):
        return [
            10 * (y[1] - y[0]),
            20 * y[0] - y[0] * y[2] - y[1],
            y[0] * y[1] - f("8/3") * y[2],
        ]

    # Eight intervals of 1/8.
    found = ode(convection, (f("1/3"), 2, 7), mpf(1))
    case(
        "lorenz",
        {"rho": "20", "start": "1/3,2,7", "interval": "1/8"},
        "8",
        x=found[0],
        y=found[1],
        z=found[2],
    )


def undamped():
    """Of one degree of freedom, with elliptic and beta functions, and dry friction."""
    n = f("5/2")
    m = mpf(2)
    k = mpf(3)
    a = f("4/3")
    case(
        "power-oscillator",
        {"exponent": "5/2", "mass": "2", "stiffness": "3", "amplitude": "4/3"},
        None,
        period=4 * sqrt(m / (2 * k * (n + 1))) * a ** ((1 - n) / 2) * beta(1 / (n + 1), mpf(1) / 2),
    )
    alpha = mpf(2)
    b3 = f("3/5")
    a = f("5/4")
    w = sqrt(alpha + b3 * a * a)
    q = b3 * a * a / (2 * (alpha + b3 * a * a))
    case(
        "duffing",
        {"alpha": "2", "beta": "3/5", "amplitude": "5/4"},
        "9/4",
        x=a * ellipfun("cn", w * f("9/4"), m=q),
        v=-a * w * ellipfun("sn", w * f("9/4"), m=q) * ellipfun("dn", w * f("9/4"), m=q),
    )
    case(
        "duffing", {"alpha": "2", "beta": "3/5", "amplitude": "5/4"}, None, period=4 * ellipk(q) / w
    )
    h = f("0.22")  # half cycles about -+h from 1, to -0.56 and 0.12
    case(
        "coulomb-oscillator",
        {"friction_force": "0.22"},
        "5",
        x=-h - (f("0.56") - h) * cos(5 - pi),
        v=(f("0.56") - h) * sin(5 - pi),
    )
    case(
        "coulomb-oscillator",
        {"friction_force": "0.22"},
        None,
        stop_time=2 * pi,
        stop_position=f("0.12"),
    )
    slip = lambda x, v, c: f("7/10") * c - x - 10 * mu(mpf(1)) + 10 * mu(1 - v)  # noqa: E731
    case(
        "stick-slip",
        {"gamma": "7/10", "eta": "5/4", "x0": "2", "v0": "-1"},
        "1/4",
        **second(slip, 2, -1, f("1/4"), f("5/4")),
    )


def mu(u):
    """Stribeck's friction of the case."""
    return f("0.3") / (1 + f("1.42") * u) + f("0.1") + f("0.01") * u * u


def pendulums():
    """On rods and strings."""
    g = f("49/5")
    length = f("5/4")
    t = f("3/4")
    theta, rate = swung(-g / length, f("7/4"), f("1/3"), t)
    case(
        "pendulum",
        {"gravity": "49/5", "length": "5/4", "theta0": "7/4", "thetadot0": "1/3"},
        "3/4",
        theta=theta,
        thetadot=rate,
        x=length * sin(theta),
        y=-length * cos(theta),
        rod_force=length * rate**2 + g * cos(theta),
    )
    case(
        "pendulum",
        {"theta0": "7/4"},
        None,
        period=4 * ellipk(sin(f("7/8")) ** 2) / sqrt(f("9.8125")),
    )
    theta, rate = swung(mpf(5), f("1/50"), mpf(0), f("4/5"))
    case(
        "pendulum-equilibria",
        {"gravity": "5", "delta": "1/50"},
        "4/5",
        x=sin(theta),
        y=cos(theta),
        vx=rate * cos(theta),
    )
    found = ode(
        double,
        (
            f("3/4"),
            f("-1/2"),
            f("1/3"),
            1,
            cos(f("3/4")),
            sin(f("3/4")),
            cos(f("1/2")),
            -sin(f("1/2")),
        ),
        f("1/4"),
    )
    case(
        "double-pendulum",
        {
            "masses": "1,3",
            "lengths": "1,1/2",
            "gravity": "5",
            "theta0": "3/4,-1/2",
            "thetadot0": "1/3,1",
        },
        "1/4",
        **dict(zip(("theta1", "theta2", "thetadot1", "thetadot2"), found[:4], strict=True)),
    )
    start, turn = waves(mpf(8))

    def rates(s, y):
        return [
            y[1],
            (2 - f("64/5") * y[4]) / f("3/2") * y[3],
            -y[3] * y[1],
            y[2] * y[1],
            *turn(y[4:]),
        ]

    found = ode(rates, (f("1/3"), f("1/5"), cos(f("1/3")), sin(f("1/3")), *start), f("1/4"))
    case(
        "kapitza-pendulum",
        {
            "length": "3/2",
            "gravity": "2",
            "drive_amplitude": "1/5",
            "drive": "8",
            "theta0": "1/3",
            "thetadot0": "1/5",
        },
        "1/4",
        theta=found[0],
        thetadot=found[1],
    )
    r, th, u, w = ode(wheel, (f("4/3"), 1, 0, 0, cos(mpf(1)), sin(mpf(1))), f("1/4"))[:4]
    case(
        "pendulum-wheel-mass",
        {
            "counter_mass": "2",
            "wheel_radius": "1/5",
            "wheel_inertia": "1/100",
            "gravity": "6",
            "r0": "4/3",
            "theta0": "1",
        },
        "1/4",
        r=r,
        theta=th,
        rdot=u + w / 5,
        thetadot=w,
    )
    case(
        "phase-flow",
        {"flow": "pendulum", "centre": "1,1/2", "gravity": "3/2"},
        None,
        area_0=outline() / 4096,
    )
    theta, rate = swung(-f("3/2"), f("19/16"), f("13/32"), f("1/2"))  # corner (12, -6)/64
    case(
        "phase-flow",
        {"flow": "pendulum", "centre": "1,1/2", "gravity": "3/2"},
        "1/2",
        x_0=theta,
        v_0=rate,
    )


def double(s, y):
    """Lagrange's equations for m1 = 1, m2 = 3, l1 = 1, l2 = 1/2, g = 5; cosines and sines of both
    angles are unknowns.
    """
    _, _, p, q, c1, s1, c2, s2 = y
    c = c1 * c2 + s1 * s2
    d = s1 * c2 - c1 * s2
    a11 = mpf(4)
    a12 = f("3/2") * c
    a22 = f("3/4")
    b1 = -f("3/2") * d * q * q - 20 * s1
    b2 = f("3/2") * d * p * p - f("15/2") * s2
    whole = a11 * a22 - a12 * a12
    return [
        p,
        q,
        (b1 * a22 - b2 * a12) / whole,
        (a11 * b2 - a12 * b1) / whole,
        -s1 * p,
        c1 * p,
        -s2 * q,
        c2 * q,
    ]


def wheel(s, y):
    """r, theta, u = r' - R theta', theta' and the cosine and sine for R = 1/5, J = 1/100, m = 1, M
    = 2, g = 6.
    """
    r, _, u, w, c, sine = y
    du = (r * w * w - 12 + 6 * c) / (3 + f("1/4"))
    return [u + w / 5, w, du, (-2 * u * w - w * w / 5 - 6 * sine) / r, -sine * w, c * w]


def outline():
    """Area of the cat's head in squares of a sixteenth of its size, by its corners."""
    right = [(0, -13), (7, -11), (12, -6), (14, 0), (13, 6), (12, 16), (5, 10)]
    head = right + [(-x, y) for x, y in right[:0:-1]]
    return (
        mpf(sum(a * d - b * c for (a, b), (c, d) in zip(head, head[1:] + head[:1], strict=True)))
        / 2
    )


def turning(j, omega, q, t, torque=lambda q, w: (0, 0, 0)):
    """omega in body axes and attitude of a body with principal moments `j` under a torque."""

    def rates(s, state):
        w = state[:3]
        attitude = state[3:]
        m = torque(attitude, w)
        # Euler: J_i w_i' = (J_k - J_l) w_k w_l + m_i for cyclic i, k, l.
        omega_rates = []
        for i in range(3):
            k = (i + 1) % 3
            l_ = (i + 2) % 3
            omega_rates.append(((j[k] - j[l_]) * w[k] * w[l_] + m[i]) / j[i])
        return [*omega_rates, *attitude_rates(attitude, w)]

    return ode(rates, [*omega, *q], t)


def attitude_rates(q, omega):
    """The rates q' = q (0, omega)/2 of an attitude q = (w, x, y, z), with omega in body axes."""
    w, x, y, z = q
    o1, o2, o3 = omega
    w_rate = -x * o1 - y * o2 - z * o3
    x_rate = w * o1 + y * o3 - z * o2
    y_rate = w * o2 + z * o1 - x * o3
    z_rate = w * o3 + x * o2 - y * o1
    return [w_rate / 2, x_rate / 2, y_rate / 2, z_rate / 2]


def up(q):
    """The vertical in body axes."""
    a, x, y, z = q
    return 2 * (x * z - a * y), 2 * (y * z + a * x), a * a - x * x - y * y + z * z


def bodies():
    """Free rigid bodies."""
    for name, given, j, w, t in (
        (
            "free-rigid-body",
            {"inertia": "2,3,4", "omega_body": "1/2,1,-3/4"},
            (2, 3, 4),
            (f("1/2"), 1, f("-3/4")),
            "3/4",
        ),
        (
            "intermediate-axis",
            {"offset": "1/20", "inertia": "1,3/2,2"},
            (1, f("3/2"), 2),
            (f("1/20"), 1, 0),
            "3/4",
        ),
        (
            "neglected-gyroscopic",
            {"inertia": "1,2,5/2", "omega_body": "3,-2,1"},
            (1, 2, f("5/2")),
            (3, -2, 1),
            "3/8",
        ),
    ):
        end = turning([mpf(x) for x in j], w, (1, 0, 0, 0), f(t))
        # Of q and -q, which are one attitude, the one with w >= 0.
        sign = 1
        if end[3] < 0:
            sign = -1
        values = {}
        for axis, x in zip("xyz", end[:3], strict=True):
            values[f"omega_body_o_{axis}"] = x
        for axis, x in zip("wxyz", end[3:], strict=True):
            values[f"attitude_o_{axis}"] = sign * x
        case(name, given, t, **values)
    turn = f("3/2") * f("5/4") / 2
    case(
        "newtons-first-law",
        {"velocity": "3,1/7,-2", "spin": "3/2"},
        "5/4",
        x=f("15/4"),
        y=f("5/28"),
        z=f("-5/2"),
        attitude_o_w=cos(turn),
        attitude_o_z=sin(turn),
    )


def torqued():
    """With damping inside, and on a tip."""
    j = (mpf(1), mpf(2), f("5/2"))
    c = f("1/5")

    def rates(s, w):
        # J w' = L x (w + c L x w) with L = J w.
        momentum = [a * b for a, b in zip(j, w, strict=True)]
        free_torque = vector_product(momentum, w)
        damped = [a + c * b for a, b in zip(w, free_torque, strict=True)]
        torque = vector_product(momentum, damped)
        return [a / b for a, b in zip(torque, j, strict=True)]

    omega = ode(rates, (1, f("1/2"), f("1/3")), f("3/4"))
    case(
        "dissipating-body",
        {"inertia": "1,2,5/2", "omega_body": "1,1/2,1/3", "damping": "1/5"},
        "3/4",
        **{f"omega_body_o_{axis}": x for axis, x in zip("xyz", omega, strict=True)},
    )
    th = f("3/4")
    j1 = f("2/3")
    j3 = f("1/4")
    weight = f("9.8125") / 2

    def torque_of_weight(q, w):
        up_x, up_y, _ = up(q)
        return weight * up_y, -weight * up_x, 0

    # phi' = 1/2 about the vertical, which lies at th from the body's third axis, and a spin of 8.
    start_omega = (0, sin(th) / 2, 8)
    start_attitude = (cos(th / 2), sin(th / 2), 0, 0)
    end = turning((j1, j1, j3), start_omega, start_attitude, f("1/4"), torque_of_weight)
    attitude = end[3:]
    a, x, y, z = attitude
    up_x, up_y, up_z = up(attitude)
    case(
        "heavy-top",
        {"inertia": "2/3,1/4", "theta0": "3/4", "phidot0": "1/2", "spin": "8"},
        "1/4",
        theta=acos(up_z),
        phi=atan2(2 * (x * z + a * y), -2 * (y * z - a * x)),
        psi=atan2(up_x, up_y),
    )


def vector_product(a, b):
    """The vector product a x b."""
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def cluster():
    """Four points as a body whose axes are not principal: the rows of its attitude, and L kept."""
    masses = (2, 1, 2, 1)
    places = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, f("-1/2"), 0)]
    omega = matrix([1, f("1/3"), f("-1/2")])
    centre = [mpf(sum(m * r[i] for m, r in zip(masses, places, strict=True))) / 6 for i in range(3)]
    arms = [matrix([r[i] - centre[i] for i in range(3)]) for r in places]
    inertia = matrix(3, 3)
    for m, r in zip(masses, arms, strict=True):
        for i in range(3):
            for k in range(3):
                inertia[i, k] += m * ((r.T * r)[0] * (i == k) - r[i] * r[k])
    momentum = inertia * omega

    def whirl(s, y):
        rows = matrix([y[3 * i : 3 * i + 3] for i in range(3)])
        w = rows * mp.lu_solve(inertia, rows.T * momentum)
        over = matrix([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]]) * rows
        return [over[i, k] for i in range(3) for k in range(3)]

    y = ode(whirl, (1, 0, 0, 0, 1, 0, 0, 0, 1), f("1/2"))
    ends = [matrix([y[3 * i : 3 * i + 3] for i in range(3)]) * arm + matrix(centre) for arm in arms]
    case(
        "rigid-cluster",
        {"masses": "2,1,2,1", "omega": "1,1/3,-1/2"},
        "1/2",
        **{
            f"r{n + 1}_o_{axis}": end[i]
            for n, end in enumerate(ends)
            for i, axis in enumerate("xyz")
        },
    )
