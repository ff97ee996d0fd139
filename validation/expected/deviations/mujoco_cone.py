"""MuJoCo's friction as shipped is a pyramid: a sphere that slides diagonally has 0.71 of Coulomb's.

A sphere that cannot turn slides on a plane, with friction 1/2. Printed are the friction over
mu times the normal force, both as impulses over 1/4 s, and by how many degrees the friction is off
the direction against the first velocity. With cone="pyramidal", the default, the limit is
abs(Fx) + abs(Fy) <= mu N along the tangents of the contact. What brakes most within it is mu N
along the tangent of the larger component of the velocity, so that the path bends towards the
diagonal; on the diagonal it is mu N / sqrt(2). With cone="elliptic" it is mu N, against the
velocity. The part stays where the step and the friction are varied.

A block that is let go on a slope, with all other settings as shipped, slides down with g (sin a -
c mu cos a), tan a = 3/4. Printed is c, from the way after 1/2 s. It is 1 where the fall line is a
tangent of the contact and 1/sqrt(2) where it is the diagonal; the contact frame stays where the
plane does, and the block may be turned with the fall line.

The documentation says of elliptic cones that they "are a better model of the physical reality, but
pyramidal cones sometimes make the solver faster and more robust" (XML reference, option, cone).
"""

import math

import mujoco

SCENE = """
<mujoco>
  <option timestep="{step}" gravity="0 0 -9.8125" cone="{cone}"/>
  <worldbody>
    <geom name="plane" type="plane" size="50 50 1"/>
    <body pos="0 0 0.5">
      <joint type="slide" axis="1 0 0"/>
      <joint type="slide" axis="0 1 0"/>
      <joint type="slide" axis="0 0 1"/>
      <geom name="sphere" type="sphere" size="0.5" mass="3"/>
    </body>
  </worldbody>
  <contact>
    <pair geom1="plane" geom2="sphere" condim="3" friction="{mu} {mu} 0 0 0"/>
  </contact>
</mujoco>
"""


def slid(degrees, cone, step=2**-10, mu=0.5):
    """Impulse of friction over mu times that of the normal force, and the angle [degrees] from the
    direction against the velocity to that of the friction.
    """
    model = mujoco.MjModel.from_xml_string(SCENE.format(step=step, cone=cone, mu=mu))
    data = mujoco.MjData(model)
    for _ in range(round(1 / step)):
        mujoco.mj_step(model, data)
    angle = math.radians(degrees)
    data.qvel[:2] = 8 * math.cos(angle), 8 * math.sin(angle)
    x = y = normal = 0.0
    for _ in range(round(0.25 / step)):
        mujoco.mj_step(model, data)
        x += data.qfrc_constraint[0]
        y += data.qfrc_constraint[1]
        normal += data.qfrc_constraint[2]
    off = math.degrees(math.atan2(-y, -x)) - degrees
    return math.hypot(x, y) / (mu * normal), off


for cone in ("pyramidal", "elliptic"):
    for degrees in (0, 30, 45, 60, 90):
        part, off = slid(degrees, cone)
        print(f"{cone}, {degrees} degrees: {part:.4f} of mu N, {off:.1f} degrees off")
for step in (2**-9, 2**-11):
    part, _ = slid(45, "pyramidal", step)
    print(f"pyramidal on the diagonal, h = {step:.6f} s: {part:.4f} of mu N")
for mu in (0.25, 1.0):
    part, _ = slid(45, "pyramidal", mu=mu)
    print(f"pyramidal on the diagonal, mu = {mu}: {part:.4f} of mu N")

SLOPE = """
<mujoco>
  <option timestep="{step}" gravity="{along_x} {along_y} {normal}" cone="{cone}"/>
  <worldbody>
    <geom type="plane" size="50 50 1" friction="{mu}"/>
    <body pos="0 0 0.125" euler="0 0 {turned}">
      <freejoint/>
      <geom type="box" size="1 1 0.125" mass="3" friction="{mu}"/>
    </body>
  </worldbody>
</mujoco>
"""


def braked(heading, cone="pyramidal", step=2**-11, turned=0, mu=0.5):
    """Part c of Coulomb's friction that brakes a block which slides down a slope of 3 in 4, whose
    fall line is at `heading` [degrees] from x; the block is `turned` [degrees] about the normal.
    """
    gravity = 9.8125
    sine, cosine = 0.6, 0.8
    along = math.cos(math.radians(heading)), math.sin(math.radians(heading))
    filled = SLOPE.format(
        step=step,
        along_x=gravity * sine * along[0],
        along_y=gravity * sine * along[1],
        normal=-gravity * cosine,
        cone=cone,
        turned=turned,
        mu=mu,
    )
    model = mujoco.MjModel.from_xml_string(filled)
    data = mujoco.MjData(model)
    duration = 0.5
    for _ in range(round(duration / step)):
        mujoco.mj_step(model, data)
    way = data.qpos[0] * along[0] + data.qpos[1] * along[1]
    # s = g (sin a - c mu cos a) t^2/2
    acceleration = 2 * way / duration**2
    return (sine - acceleration / gravity) / (mu * cosine)


for cone in ("pyramidal", "elliptic"):
    for heading in (0, 45, 90):
        print(f"block, {cone}, fall line at {heading} degrees: c = {braked(heading, cone):.3f}")
for step in (2**-9, 2**-13):
    print(f"block on the diagonal, h = {step:.6f} s: c = {braked(45, step=step):.3f}")
for turned in (45, 90):
    print(f"block turned by {turned} degrees, on the diagonal: c = {braked(45, turned=turned):.3f}")
print(f"block turned by 45 degrees, along a tangent: c = {braked(0, turned=45):.3f}")
for mu in (0.25, 0.7):
    print(f"block on the diagonal, mu = {mu}: c = {braked(45, mu=mu):.3f}")
