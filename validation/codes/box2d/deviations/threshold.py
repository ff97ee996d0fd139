"""Box2D's disc does not bounce at 1 unit of length a second or less.

`b2_velocityThreshold` is compiled in; its documentation calls collisions slower than it inelastic.
A unit is a metre by default, so that a ball that falls from 5 cm stays on the ground.
"""

import Box2D


def bounced(speed):
    """The velocity after a disc of that speed has met an edge, without gravity."""
    world = Box2D.b2World(gravity=(0, 0))
    edge = Box2D.b2EdgeShape(vertices=[(-50, 0), (50, 0)])
    world.CreateStaticBody().CreateFixture(shape=edge, restitution=0.75)
    disc = world.CreateDynamicBody(position=(0, 1), linearVelocity=(0, -speed), allowSleep=False)
    disc.CreateCircleFixture(radius=0.5, density=1.0, restitution=0.75)
    for _ in range(round(0.8 / speed / 1e-3)):
        world.Step(1e-3, 50, 50)
    return disc.linearVelocity[1]


for speed in (4.0, 1.1, 1.0, 0.9, 0.1):
    print(f"{speed:4} units a second: restitution {bounced(speed) / speed:.3f} (law: 0.75)")
