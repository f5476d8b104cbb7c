// Binding of the joint controller of the core: no formula.
#include "arrays.h"

void bind_joint(nb::module_ &m) { (void)m; }
