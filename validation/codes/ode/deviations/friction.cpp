// Friction of ODE: without dContactApprox1 a force in newtons, with it a pyramid about two tangents.
//
// contact.h has `dReal mu`, which "must always be defined", the mode dContactApprox1 without a word,
// and dContactFDir1, "Use FDir for the first friction value". Varied here: the mode, the weight, and
// the direction of the slip from the first tangent.
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <ode/ode.h>

static const double STEP = 1.0 / 128;
static const double FRICTION = 0.5;

/* The force of friction on a body of 1 kg that slides at 1000 m/s, in units of mu m g. */
static double braked(int mode, double gravity, double degrees)
{
    dWorldID world = dWorldCreate();
    dWorldSetGravity(world, 0, 0, -gravity);
    dWorldSetCFM(world, 0);
    dBodyID body = dBodyCreate(world);
    const double angle = degrees * M_PI / 180;
    const double direction[3] = {std::cos(angle), std::sin(angle), 0};
    dBodySetLinearVel(body, 1000 * direction[0], 1000 * direction[1], 0);
    dContact contact = {};
    contact.surface.mode = mode;
    contact.surface.mu = FRICTION;
    contact.geom.normal[2] = 1;
    contact.fdir1[0] = direction[0];
    contact.fdir1[1] = direction[1];
    dJointAttach(dJointCreateContact(world, nullptr, &contact), body, nullptr);
    dWorldStep(world, STEP);
    const double *v = dBodyGetLinearVel(body);
    const double lost = 1000 - std::hypot(v[0], v[1]);
    dWorldDestroy(world);
    return lost / STEP / (FRICTION * gravity);
}

int main()
{
    dInitODE2(0);
    for (double gravity : {1.0, 10.0, 100.0}) {
        printf("g = %g m/s^2: friction over mu m g is %.3f", gravity, braked(0, gravity, 0));
        printf(", with dContactApprox1 %.3f\n", braked(dContactApprox1, gravity, 0));
    }
    for (double degrees : {0.0, 15.0, 30.0, 45.0}) {
        printf("slip at %g degrees: %.3f", degrees, braked(dContactApprox1, 10, degrees));
        const double along = braked(dContactApprox1 | dContactFDir1, 10, degrees);
        printf(", with dContactFDir1 along the slip %.3f\n", along);
    }
    dCloseODE();
}
