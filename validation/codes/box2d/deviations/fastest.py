"""Box2D's bodies move by 2 units of length in a step at most, and turn by a quarter of a turn.

`b2_maxTranslation` and `b2_maxRotation` are compiled in; a velocity beyond them is cut for good,
and nothing says so. The manual names them among the settings, as a guard against rounding.
"""

import Box2D

for speed in (10.0, 100.0, 1000.0):
    world = Box2D.b2World(gravity=(0, 0))
    body = world.CreateDynamicBody(linearVelocity=(speed, 0), allowSleep=False, linearDamping=0)
    body.CreateCircleFixture(radius=0.5, density=1.0)
    for _ in range(60):
        world.Step(1 / 60, 8, 3)
    print(f"{speed:6} units a second for a second: it moves {body.position[0]:.2f} units")
