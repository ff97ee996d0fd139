"""Box2D's edges have a skin: a disc rests almost 0.01 units above the edge that it lies on.

`b2_polygonRadius` is twice `b2_linearSlop` = 0.005 units, and small overlaps are left alone;
both are compiled in. The manual says that Box2D is tuned for bodies of 0.1 to 10 m.
"""

import Box2D


def height(radius):
    """The height over the edge of a disc that has come to rest, less its radius."""
    world = Box2D.b2World(gravity=(0, -10))
    edge = Box2D.b2EdgeShape(vertices=[(-50, 0), (50, 0)])
    world.CreateStaticBody().CreateFixture(shape=edge)
    disc = world.CreateDynamicBody(position=(0, radius + 0.02), allowSleep=False)
    disc.CreateCircleFixture(radius=radius, density=1.0)
    for _ in range(2000):
        world.Step(1e-3, 50, 50)
    return disc.position[1] - radius


for radius in (10.0, 1.0, 0.1, 0.01):
    gap = height(radius)
    print(f"radius {radius:5}: rests {gap:.4f} above the edge, {gap / radius:.1e} of its radius")
