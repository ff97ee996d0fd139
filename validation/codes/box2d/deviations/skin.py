"""Box2D 2.3: edges have a skin, and a disc rests almost 0.01 units above the edge that it lies on.

Box2D/Common/b2Settings.h says of `b2_polygonRadius`, which is twice `b2_linearSlop` = 0.005 units:
"The radius of the polygon/edge shape skin. This should not be modified." Both are compiled in. A
box has a skin as well: it rests 0.015 units above, two skins less one slop of overlap that is left
alone. One that starts there is not moved.
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


def pushed_out(start):
    """The way up [units] of a box that starts at a height [units] above the edge."""
    world = Box2D.b2World(gravity=(0, -10))
    edge = Box2D.b2EdgeShape(vertices=[(-50, 0), (50, 0)])
    world.CreateStaticBody().CreateFixture(shape=edge)
    box = world.CreateDynamicBody(position=(0, 1 + start), allowSleep=False)
    box.CreatePolygonFixture(box=(1, 1), density=1.0)
    for _ in range(2000):
        world.Step(1e-3, 50, 50)
    return box.position[1] - 1 - start


for start in (0.0, 0.005, 0.01, 0.015):
    print(f"a box that starts {start} above is pushed out by {pushed_out(start):.4f}")
