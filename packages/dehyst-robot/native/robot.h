// Parts of the robot's extension module.
#ifndef DEHYST_NATIVE_ROBOT_H
#define DEHYST_NATIVE_ROBOT_H

#include "arrays.h"

void bind_joint(nb::module_ &m);
void bind_plant(nb::module_ &m);
void bind_mujoco_plugin(nb::module_ &m);
void bind_robot(nb::module_ &m);

#endif
