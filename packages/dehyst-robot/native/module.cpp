// nanobind binding of the joint controller and of the simulated plant: arrays in, arrays out, no formula.
#include "robot.h"
#include "stoppable.h"

NB_MODULE(_native, m)
{
    nb::set_leak_warnings(false); // what a model keeps until the interpreter's end is no leak
    m.doc() = "dehyst's joint controller, the simulated pneumatic plant and the closed loop of both.";
    bind_stoppable();
    bind_joint(m);
    bind_plant(m);
    bind_mujoco_plugin(m);
    bind_robot(m);
}
