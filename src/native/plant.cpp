// Binding of one simulated pneumatic joint: no formula.
#include "arrays.h"

void bind_plant(nb::module_ &m) { (void)m; }
