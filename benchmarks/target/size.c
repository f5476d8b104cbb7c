/* The least that a program needs of an exported unit, to see how much that is; EMPTY: all but that. */
#include "io.h"

#ifdef EMPTY
int main(void) { return 0; }
#else
#include "unit.h"

static unit_state unit;

#ifdef JOINT
int main(void)
{
    static dehyst_joint_sensors sensors;
    static dehyst_joint_reference reference;
    static dehyst_joint_output output;
    io_read(&sensors, sizeof sensors);
    io_read(&reference, sizeof reference);
    unit_reset(&unit, &sensors);
    unit_step(&unit, &sensors, &reference, 7u, &output);
    io_write(&output, sizeof output);
    return 0;
}
#else
int main(void)
{
    dehyst_real x;
    io_read(&x, sizeof x);
    unit_reset(&unit);
    x = unit_step(&unit, x, 1);
    io_write(&x, sizeof x);
    return (int)unit_flags(&unit);
}
#endif
#endif
