"""Units: degrees, millimetres, grams, diameters."""

from functools import partial

import numpy as np

from refdem.faults.change import of_bodies, of_columns, of_elements, scaled
from refdem.faults.fault import Fault
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

units = partial(Fault, kind="units", on=("oscillator",))

FAULTS = (
    units(
        name="degrees-out",
        sentence="Angular velocities are written in degrees per second.",
        on=("tumbler",),
        sees=("error", "omega.x"),
        after=of_columns(omega=np.degrees),
    ),
    units(
        name="degrees-in",
        sentence="Angular velocities are read in degrees per second.",
        on=("tumbler",),
        sees=("error", "omega_body.x"),
        before=of_bodies(omega=np.radians),
    ),
    units(
        name="turns-a-minute",
        sentence="Angular velocities are written in revolutions per minute.",
        on=("flyer",),
        sees=("error", "omega.z"),
        after=of_columns(omega=lambda w: w * 30 / np.pi),
    ),
    units(
        name="millimetres",
        sentence="Positions are written in millimetres.",
        sees=("error", "x"),
        after=of_columns(position=lambda r: 1e3 * r),
    ),
    units(
        name="millimetres-in",
        sentence="Positions are read and written in millimetres.",
        on=("orbit",),
        sees=("error", "vx"),
        before=of_bodies(position=lambda r: 1e3 * r),
    ),
    units(
        name="grams",
        sentence="The mass is read in grams.",
        sees=("error", "v"),
        before=of_bodies(mass=lambda m: 1e3 * m),
    ),
    units(
        name="stiffness-per-millimetre",
        sentence="The stiffness is read in newton per centimetre.",
        sees=("error", "x"),
        before=of_elements(Spring, stiffness=scaled(0.01)),
    ),
    units(
        name="kilogram-force",
        sentence="Forces are read in kilogram-force.",
        on=("rubbing",),
        sees=("stop", "stop_position"),
        before=of_elements(Slider, normal_force=scaled(1 / 9.80665)),
    ),
    units(
        name="gravity-in-feet",
        sentence="Gravity is read in feet per square second.",
        on=("swing",),
        sees=("error", "theta"),
        before=of_elements(UniformGravity, g=scaled(3.2808)),
    ),
    units(
        name="percent",
        sentence="The coefficient of friction is read in percent.",
        on=("scrape",),
        sees=("error", "omega1.z"),
        before=of_elements(Contact, friction=scaled(0.01)),
    ),
    units(
        name="diameter-for-radius",
        sentence=(
            "The contact law uses diameters instead of radii, so that the stiffness is doubled."
        ),
        on=("bounce",),
        sees=("error", "v1.x"),
        before=of_elements(Contact, stiffness=scaled(2.0)),
    ),
    units(
        name="minutes",
        sentence="Velocities are written in metres per minute.",
        on=("ellipse",),
        sees=("error", "vx"),
        after=of_columns(velocity=lambda v: 60 * v),
    ),
)
