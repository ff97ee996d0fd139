// An overlap in ODE throws a ball up: by 0.2 of the overlap a step, the world's ERP.
//
// objects.h says of dWorldSetERP: "Typical values are in the range 0.1--0.8. The default is 0.2."
// Varied here: ERP and the overlap, for a ball at rest without gravity and without restitution.
#include <cstdio>
#include <initializer_list>
#include <ode/ode.h>

static const double STEP = 1.0 / 128;

/* The speed after one step of a ball that overlaps a floor, over the overlap a step. */
static double thrown(double erp, double overlap)
{
    dWorldID world = dWorldCreate();
    dWorldSetERP(world, erp);
    dBodyID body = dBodyCreate(world);
    dContact contact = {};
    contact.geom.normal[2] = 1;
    contact.geom.depth = overlap;
    dJointAttach(dJointCreateContact(world, nullptr, &contact), body, nullptr);
    dWorldStep(world, STEP);
    const double speed = dBodyGetLinearVel(body)[2];
    dWorldDestroy(world);
    return speed * STEP / overlap;
}

int main()
{
    dInitODE2(0);
    for (double erp : {0.8, 0.2, 0.1, 0.0})
        for (double overlap : {1e-2, 1e-4})
            printf("ERP %g, overlap %g m: thrown by %.3f of it a step\n", erp, overlap,
                   thrown(erp, overlap));
    dCloseODE();
}
