/* Runs an exported joint controller over recorded periods: job.bin in, answer.bin out.
 *
 *   job:    number of periods, then for each: 3 sensors and 7 references as IEEE words, switches
 *   answer: for each period: 13 outputs as IEEE words, flags
 *
 * steps() is the only caller of unit_step. */
#include "io.h"
#include "unit.h"

static unit_state unit;

typedef struct period {
    dehyst_real input[10];
    uint32_t switches;
} __attribute__((packed)) period;

typedef struct answer {
    dehyst_real output[13];
    uint32_t flags;
} __attribute__((packed)) answer;

static dehyst_joint_sensors sensors_of(const period *in)
{
    const dehyst_joint_sensors sensors = {in->input[0], {in->input[1], in->input[2]}};
    return sensors;
}

__attribute__((noinline)) static void steps(uint32_t periods)
{
    for (uint32_t k = 0; k < periods; ++k) {
        period in;
        answer out;
        dehyst_joint_output found;
        io_read(&in, sizeof in);
        const dehyst_joint_sensors sensors = sensors_of(&in);
        const dehyst_joint_reference reference = {in.input[3], in.input[4], in.input[5], in.input[6],
                                                  in.input[7], in.input[8], in.input[9]};
        if (k == 0) unit_reset(&unit, &sensors);
        unit_step(&unit, &sensors, &reference, in.switches, &found);
        const dehyst_real values[13] = {found.valve[0],    found.valve[1], found.desired[0], found.desired[1],
                                        found.pressure_difference, found.torque, found.integrator,
                                        found.compensation, found.angle,   found.velocity,   found.load,
                                        found.contact,     found.doubt};
        for (int i = 0; i < 13; ++i) out.output[i] = values[i];
        out.flags = found.flags;
        io_write(&out, sizeof out);
    }
}

int main(void)
{
    uint32_t periods = 0;
    io_read(&periods, sizeof periods);
    steps(periods);
    return 0;
}
