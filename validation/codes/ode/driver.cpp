// A scene in ODE: free bodies, rigid spheres and boxes, planes, rods, springs, gravity.
//
// Rods are ODE's distance joints (DBall). ODE has no springs: they are forces, which dBodyAddForce
// takes for one step. Debian's library is in double precision.
#include "refdem_driver.h"
#include <array>
#include <cmath>
#include <ode/ode.h>
#include <string>
#include <vector>

using Vector = std::array<double, 3>;

// Of a point [kg m^2], which feels no torque: ODE takes no body without inertia.
static const double LEAST_MOMENT = 1e-3;
// Contacts of a pair of shapes at most; a box on a plane has four.
enum { MOST_CONTACTS = 8 };

struct Spring {
    int a, b;
    double stiffness, length;
    Vector end;
};

// All that belongs to one request: nothing stays for the next.
struct World {
    dWorldID world;
    dSpaceID space;
    dJointGroupID contacts;
    std::vector<dBodyID> bodies;
    std::vector<Spring> springs;
    bool has_law = false;
    double softness = 0, restitution = 0, friction = 0, step = 0;
    std::string unsupported;

    World() : world(dWorldCreate()), space(dSimpleSpaceCreate(nullptr)),
              contacts(dJointGroupCreate(0))
    {
    }
    ~World()
    {
        dJointGroupDestroy(contacts);
        dSpaceDestroy(space);
        dWorldDestroy(world);
    }
};

static Vector vector(const char *format, int i)
{
    Vector out;
    refdem_vector(out.data(), format, i);
    return out;
}

static int number(const char *format, int i) { return static_cast<int>(refdem_number(format, i)); }

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// ---- The scene ----

static void read_law(World &world, int i)
{
    world.has_law = true;
    world.restitution = refdem_number("scene.elements.%d.restitution", i);
    world.friction = refdem_number("scene.elements.%d.friction", i);
    if (std::string(refdem_text("scene.elements.%d.law", i)) != "rigid")
        world.unsupported = "contact laws other than the rigid one";
    if (refdem_number("scene.elements.%d.tangential_restitution", i) != 0)
        world.unsupported = "a tangential restitution";
}

// The half sides (3) [m] of a polyhedron with eight corners at +-a, +-b, +-c.
static Vector half_sides(World &world, int i)
{
    Vector half{};
    const int corners = number("scene.bodies.%d.shape.vertices.count", i);
    for (int n = 0; n < corners; n++)
        for (int axis = 0; axis < 3; axis++) {
            const double x =
                std::fabs(refdem_number("scene.bodies.%d.shape.vertices.%d.%d", i, n, axis));
            if (n > 0 && x != half[axis])
                world.unsupported = "polyhedra other than boxes about their centre";
            half[axis] = x;
        }
    if (corners != 8)
        world.unsupported = "polyhedra other than boxes about their centre";
    return half;
}

static void put_shape(World &world, dBodyID body, int i)
{
    const std::string kind = refdem_text("scene.bodies.%d.shape.kind", i);
    dGeomID shape = nullptr;
    if (kind == "sphere") {
        shape = dCreateSphere(world.space, refdem_number("scene.bodies.%d.shape.radius", i));
    } else if (kind == "polyhedron") {
        // Four points of contact share one body: without softness they have no one solution.
        dWorldSetCFM(world.world, world.softness);
        const Vector half = half_sides(world, i);
        shape = dCreateBox(world.space, 2 * half[0], 2 * half[1], 2 * half[2]);
    }
    if (shape)
        dGeomSetBody(shape, body);
}

static void put_body(World &world, int i)
{
    const dBodyID body = dBodyCreate(world.world);
    Vector J = vector("scene.bodies.%d.inertia", i);
    for (double &moment : J)
        if (moment == 0)
            moment = LEAST_MOMENT;
    dMass mass;
    const double kilograms = refdem_number("scene.bodies.%d.mass", i);
    dMassSetParameters(&mass, kilograms, 0, 0, 0, J[0], J[1], J[2], 0, 0, 0);
    dBodySetMass(body, &mass);
    const Vector r = vector("scene.bodies.%d.position", i);
    const Vector v = vector("scene.bodies.%d.velocity", i);
    const Vector omega = vector("scene.bodies.%d.omega", i);
    dQuaternion q;
    refdem_attitude(q, i);
    dBodySetPosition(body, r[0], r[1], r[2]);
    dBodySetQuaternion(body, q);
    dBodySetLinearVel(body, v[0], v[1], v[2]);
    dBodySetAngularVel(body, omega[0], omega[1], omega[2]);
    dBodySetFiniteRotationMode(body, 1);
    if (world.has_law)
        put_shape(world, body, i);
    if (refdem_number("scene.bodies.%d.fixed", i) != 0)
        world.unsupported = "fixed bodies";
    world.bodies.push_back(body);
}

static void put_plane(World &world, int i)
{
    const Vector n = vector("scene.elements.%d.normal", i);
    const Vector point = vector("scene.elements.%d.point", i);
    if (!world.has_law)
        world.unsupported = "planes without a contact law";
    dCreatePlane(world.space, n[0], n[1], n[2], dot(n.data(), point.data()));
}

// The ends of a link are centres, or a place in space where b is -1.
static void refuse_anchors(World &world, int i)
{
    const bool is_off_a = vector("scene.elements.%d.anchor_a", i) != Vector{};
    const bool is_off_b = vector("scene.elements.%d.anchor_b", i) != Vector{};
    if (is_off_a || (number("scene.elements.%d.b", i) >= 0 && is_off_b))
        world.unsupported = "anchors off the centre";
}

static void put_rod(World &world, int i)
{
    refuse_anchors(world, i);
    const int b = number("scene.elements.%d.b", i);
    const dBodyID first = world.bodies[number("scene.elements.%d.a", i)];
    const dBodyID second = b < 0 ? nullptr : world.bodies[b];
    const Vector place = vector("scene.elements.%d.anchor_b", i);
    const double *start = dBodyGetPosition(first);
    const double *end = second ? dBodyGetPosition(second) : place.data();
    const dJointID rod = dJointCreateDBall(world.world, nullptr);
    dJointAttach(rod, first, second);
    dJointSetDBallAnchor1(rod, start[0], start[1], start[2]);
    dJointSetDBallAnchor2(rod, end[0], end[1], end[2]);
    dJointSetDBallDistance(rod, refdem_number("scene.elements.%d.length", i));
}

static void read_spring(World &world, int i)
{
    refuse_anchors(world, i);
    Spring spring;
    spring.a = number("scene.elements.%d.a", i);
    spring.b = number("scene.elements.%d.b", i);
    spring.stiffness = refdem_number("scene.elements.%d.stiffness", i);
    spring.length = refdem_number("scene.elements.%d.length", i);
    spring.end = vector("scene.elements.%d.anchor_b", i);
    const bool is_linear = refdem_number("scene.elements.%d.exponent", i) == 1 &&
                           refdem_number("scene.elements.%d.quadratic", i) == 0 &&
                           refdem_number("scene.elements.%d.cubic", i) == 0;
    if (!is_linear)
        world.unsupported = "springs that are not linear";
    world.springs.push_back(spring);
}

static void read_elements(World &world)
{
    static const char *const known[] = {"uniform_gravity", "plane",  "contact",
                                        "rod",             "spring", nullptr};
    const char *other = refdem_other_element(known);
    if (other)
        world.unsupported = std::string("element ") + other;
    for (int i = refdem_element("contact", 0); i >= 0; i = refdem_element("contact", i + 1))
        read_law(world, i);
    const int bodies = static_cast<int>(refdem_number("scene.bodies.count"));
    for (int i = 0; i < bodies; i++)
        put_body(world, i);
    Vector g{};
    for (int i = refdem_element("uniform_gravity", 0); i >= 0;
         i = refdem_element("uniform_gravity", i + 1)) {
        const Vector field = vector("scene.elements.%d.g", i);
        for (int axis = 0; axis < 3; axis++)
            g[axis] += field[axis];
    }
    dWorldSetGravity(world.world, g[0], g[1], g[2]);
    for (int i = refdem_element("plane", 0); i >= 0; i = refdem_element("plane", i + 1))
        put_plane(world, i);
    for (int i = refdem_element("rod", 0); i >= 0; i = refdem_element("rod", i + 1))
        put_rod(world, i);
    for (int i = refdem_element("spring", 0); i >= 0; i = refdem_element("spring", i + 1))
        read_spring(world, i);
}

// ---- One step ----

// A spring between centres, or to a place: F = k (|r| - l) r / |r|.
static void pull(const World &world, const Spring &spring)
{
    const dBodyID a = world.bodies[spring.a];
    const dBodyID b = spring.b < 0 ? nullptr : world.bodies[spring.b];
    const double *start = dBodyGetPosition(a);
    const double *end = b ? dBodyGetPosition(b) : spring.end.data();
    const Vector arm = {end[0] - start[0], end[1] - start[1], end[2] - start[2]};
    // A spring without length needs no direction.
    double scale = spring.stiffness;
    if (spring.length > 0)
        scale *= 1 - spring.length / std::sqrt(dot(arm.data(), arm.data()));
    dBodyAddForce(a, scale * arm[0], scale * arm[1], scale * arm[2]);
    if (b)
        dBodyAddForce(b, -scale * arm[0], -scale * arm[1], -scale * arm[2]);
}

// The velocity of a point of a body, or of what rests.
static void point_velocity(dBodyID body, const double *place, double *out)
{
    dVector3 found = {0, 0, 0, 0};
    if (body)
        dBodyGetPointVel(body, place[0], place[1], place[2], found);
    for (int axis = 0; axis < 3; axis++)
        out[axis] = found[axis];
}

// Sets the direction of friction to that of the slip; false if there is none.
static bool has_slip(dContact &contact, dBodyID a, dBodyID b)
{
    Vector first, second, slip;
    point_velocity(a, contact.geom.pos, first.data());
    point_velocity(b, contact.geom.pos, second.data());
    for (int axis = 0; axis < 3; axis++)
        slip[axis] = first[axis] - second[axis];
    const double closing = dot(slip.data(), contact.geom.normal);
    for (int axis = 0; axis < 3; axis++)
        slip[axis] -= closing * contact.geom.normal[axis];
    const double speed = std::sqrt(dot(slip.data(), slip.data()));
    for (int axis = 0; axis < 3; axis++)
        contact.fdir1[axis] = speed > 0 ? slip[axis] / speed : 0;
    return speed > 0;
}

static void touch(void *data, dGeomID first, dGeomID second)
{
    World &world = *static_cast<World *>(data);
    const dBodyID a = dGeomGetBody(first);
    const dBodyID b = dGeomGetBody(second);
    if (!a && !b)
        return;
    dContact contacts[MOST_CONTACTS] = {};
    const int count =
        dCollide(first, second, MOST_CONTACTS, &contacts[0].geom, sizeof(dContact));
    for (int n = 0; n < count; n++) {
        dContact &contact = contacts[n];
        contact.surface.mode = dContactBounce | dContactApprox1;
        contact.surface.mu = world.friction;
        contact.surface.bounce = world.restitution;
        contact.surface.bounce_vel = 0;
        if (has_slip(contact, a, b))
            contact.surface.mode |= dContactFDir1;
        dJointAttach(dJointCreateContact(world.world, world.contacts, &contact), a, b);
    }
}

static void advance(World &world)
{
    for (const Spring &spring : world.springs)
        pull(world, spring);
    if (world.has_law)
        dSpaceCollide(world.space, &world, touch);
    dWorldStep(world.world, world.step);
    dJointGroupEmpty(world.contacts);
}

// ---- The run ----

static const char *solve(FILE *trajectory)
{
    static std::string why;
    World world;
    world.step = refdem_number("step");
    dWorldSetERP(world.world, 0);
    world.softness = dWorldGetCFM(world.world);
    dWorldSetCFM(world.world, 0);
    dRandSetSeed(0);
    read_elements(world);
    why = world.unsupported;
    if (!why.empty())
        return why.c_str();
    const double start = refdem_number("times.0");
    const long stride = static_cast<long>(refdem_number("stride"));
    const long samples = static_cast<long>(refdem_number("times.count"));
    for (long n = 0; n < samples; n++) {
        // Steps are counted; times are never compared, for a sum of steps is rounded.
        for (long k = 0; n > 0 && k < stride; k++)
            advance(world);
        const double t = start + static_cast<double>(n * stride) * world.step;
        for (std::size_t i = 0; i < world.bodies.size(); i++) {
            const dBodyID body = world.bodies[i];
            refdem_body(trajectory, t, static_cast<int>(i), dBodyGetPosition(body),
                        dBodyGetLinearVel(body), dBodyGetQuaternion(body),
                        dBodyGetAngularVel(body));
        }
    }
    return nullptr;
}

int main(int argc, char **argv)
{
    dInitODE2(0);
    dSetMessageHandler(nullptr);
    const int status = refdem_run(argc, argv, solve);
    dCloseODE();
    return status;
}
