// Binding of the closed loop: sensors, controllers, pneumatics, rigid body: no formula.
#include "arrays.h"

void bind_robot(nb::module_ &m) { (void)m; }
