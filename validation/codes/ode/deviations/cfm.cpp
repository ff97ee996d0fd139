// Contacts of ODE yield by the world's CFM: a box that friction holds creeps in proportion to it.
//
// objects.h says of dWorldSetCFM: "The default is 10^-5 if single precision is being used, or 10^-10
// if double precision is being used." Varied here: CFM, for a ball that bounces, and for a box on a
// slope of 3 in 4 with friction of 3/4. At 0 the four points of the box have no one solution.
#include <cstdio>
#include <initializer_list>
#include <ode/ode.h>

static const double STEP = 1.0 / 2048;
static const double FRICTION = 0.75;

static dWorldID world;
static dJointGroupID joints;

static void touch(void *, dGeomID a, dGeomID b)
{
    dContact contacts[8] = {};
    const int count = dCollide(a, b, 8, &contacts[0].geom, sizeof(dContact));
    for (int n = 0; n < count; n++) {
        contacts[n].surface.mode = dContactBounce | dContactApprox1;
        contacts[n].surface.mu = FRICTION;
        contacts[n].surface.bounce = 0.75;
        dJointID joint = dJointCreateContact(world, joints, &contacts[n]);
        dJointAttach(joint, dGeomGetBody(a), dGeomGetBody(b));
    }
}

/* A body of 1 kg on a floor after some steps, by its position and velocity. */
static void run(double cfm, bool is_box, int steps, double *x, double *v)
{
    world = dWorldCreate();
    joints = dJointGroupCreate(0);
    dSpaceID space = dSimpleSpaceCreate(nullptr);
    dWorldSetERP(world, 0);
    dWorldSetCFM(world, cfm);
    dCreatePlane(space, 0, 0, 1, 0);
    dBodyID body = dBodyCreate(world);
    dGeomSetBody(is_box ? dCreateBox(space, 2, 2, 0.25) : dCreateSphere(space, 0.125), body);
    dBodySetPosition(body, 0, 0, 0.125);
    if (is_box)
        dWorldSetGravity(world, 0.6 * 9.8125, 0, -0.8 * 9.8125);
    else
        dBodySetLinearVel(body, 0, 0, -1);
    for (int n = 0; n < steps; n++) {
        dSpaceCollide(space, nullptr, touch);
        dWorldStep(world, STEP);
        dJointGroupEmpty(joints);
    }
    for (int axis = 0; axis < 3; axis++) {
        x[axis] = dBodyGetPosition(body)[axis];
        v[axis] = dBodyGetLinearVel(body)[axis];
    }
    dSpaceDestroy(space);
    dWorldDestroy(world);
}

int main()
{
    dInitODE2(0);
    dSetMessageHandler([](int, const char *, va_list) {});
    double x[3], v[3];
    for (double cfm : {1e-5, 1e-8, 1e-9, 1e-10, 0.0}) {
        run(cfm, false, 1, x, v);
        printf("CFM %g: a ball bounces with 0.75 - %.1e", cfm, 0.75 - v[2]);
        run(cfm, true, 1024, x, v);
        printf("; a box creeps by %.1e m in 0.5 s, at %.1e m/s\n", x[0], v[0]);
    }
    dCloseODE();
}
