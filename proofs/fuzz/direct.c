/* The controller with a direct inverse that learns in place of a compensator. */
#define DIRECT
#include "joint.c"
