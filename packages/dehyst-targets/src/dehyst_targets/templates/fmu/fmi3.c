/* SPDX-License-Identifier: 0BSD
 *
 * FMI 3.0, co-simulation. Included by all.c, after unit.h and fmu.h. */
#include "fmi3.h"

#define ANY ((1u << FMU_INSTANTIATED) | (1u << FMU_INITIALIZING) | (1u << FMU_STEPPING) | (1u << FMU_TERMINATED))
#define SETTABLE ((1u << FMU_INSTANTIATED) | (1u << FMU_INITIALIZING) | (1u << FMU_STEPPING))

static void say_3(const fmu_instance *fmu, int status, const char *category, const char *message)
{
    fmi3LogMessageCallback log = (fmi3LogMessageCallback)fmu->log;
    log(fmu->environment, (fmi3Status)status, category, message);
}

FMI3(const char *, fmi3GetVersion)(void)
{
    return "3.0";
}

FMI3_STATUS(fmi3SetDebugLogging)(fmi3Instance c, fmi3Boolean on, size_t count, const fmi3String category[])
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi3SetDebugLogging");
    return fmu ? (fmi3Status)fmu_log_categories(fmu, on, count, category) : fmi3Error;
}

/* ---- Life. */

static fmi3Instance refuse_3(fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, const char *why)
{
    if (log) {
        log(environment, fmi3Error, fmu_category[FMU_ERROR], why);
    }
    return NULL;
}

FMI3(fmi3Instance, fmi3InstantiateModelExchange)(fmi3String name, fmi3String token, fmi3String resources,
                                                 fmi3Boolean visible, fmi3Boolean logging,
                                                 fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging;
    return refuse_3(environment, log, "this FMU is for co-simulation only");
}

FMI3(fmi3Instance, fmi3InstantiateScheduledExecution)(fmi3String name, fmi3String token, fmi3String resources,
                                                      fmi3Boolean visible, fmi3Boolean logging,
                                                      fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                                      fmi3ClockUpdateCallback clock, fmi3LockPreemptionCallback lock,
                                                      fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)clock, (void)lock, (void)unlock;
    return refuse_3(environment, log, "this FMU is for co-simulation only");
}

FMI3(fmi3Instance, fmi3InstantiateCoSimulation)(fmi3String name, fmi3String token, fmi3String resources,
                                                fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean event_mode,
                                                fmi3Boolean early_return, const fmi3ValueReference intermediate[],
                                                size_t intermediates, fmi3InstanceEnvironment environment,
                                                fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    (void)resources, (void)visible, (void)early_return, (void)intermediate, (void)update;
    if (!name || !token || strcmp(token, FMU_TOKEN) != 0) {
        return refuse_3(environment, log, "the token is not " FMU_TOKEN ": description and binary differ");
    }
    if (event_mode || intermediates) {
        return refuse_3(environment, log, "this FMU has no event mode and no intermediate variables");
    }
    fmu_instance *fmu = (fmu_instance *)calloc(1, sizeof *fmu);
    if (!fmu) {
        return NULL;
    }
    fmu->allocate = calloc;
    fmu->release = free;
    fmu->environment = environment;
    fmu->log = (void (*)(void))log;
    fmu->say = say_3;
    fmu_made(fmu, name, logging);
    return fmu;
}

FMI3(void, fmi3FreeInstance)(fmi3Instance c)
{
    fmu_instance *fmu = fmu_known(c);
    if (fmu) {
        fmu->magic = 0;
        fmu->release(fmu);
    }
}

FMI3_STATUS(fmi3EnterInitializationMode)(fmi3Instance c, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                         fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop)
{
    fmu_instance *fmu = fmu_in(c, 1u << FMU_INSTANTIATED, "fmi3EnterInitializationMode");
    (void)has_tolerance, (void)tolerance;
    if (!fmu || fmu_set_times(fmu, start, has_stop, stop) != FMU_OK) {
        return fmi3Error;
    }
    fmu->mode = FMU_INITIALIZING;
    return fmi3OK;
}

FMI3_STATUS(fmi3ExitInitializationMode)(fmi3Instance c)
{
    fmu_instance *fmu = fmu_in(c, 1u << FMU_INITIALIZING, "fmi3ExitInitializationMode");
    return fmu ? (fmi3Status)fmu_go(fmu) : fmi3Error;
}

FMI3_STATUS(fmi3Terminate)(fmi3Instance c)
{
    fmu_instance *fmu = fmu_in(c, 1u << FMU_STEPPING, "fmi3Terminate");
    if (!fmu) {
        return fmi3Error;
    }
    fmu->mode = FMU_TERMINATED;
    return fmi3OK;
}

FMI3_STATUS(fmi3Reset)(fmi3Instance c)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi3Reset");
    if (!fmu) {
        return fmi3Error;
    }
    fmu_begin(fmu);
    return fmi3OK;
}

/* ---- Variables: Float64, Float32, Int32 and Boolean. */

#define REALS(name, type)                                                                                             \
    FMI3_GET(name)                                                                                                    \
    {                                                                                                                 \
        fmu_instance *fmu = fmu_in(c, ANY, "fmi3Get" #name);                                                          \
        return fmu ? (fmi3Status)fmu_get_real(fmu, type, vr, count, value, values) : fmi3Error;                       \
    }                                                                                                                 \
    FMI3_SET(name)                                                                                                    \
    {                                                                                                                 \
        fmu_instance *fmu = fmu_in(c, SETTABLE, "fmi3Set" #name);                                                     \
        return fmu ? (fmi3Status)fmu_set_real(fmu, type, vr, count, value, values) : fmi3Error;                       \
    }

REALS(Float64, FMU_REAL)
REALS(Float32, FMU_SINGLE)

FMI3_GET(Int32)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi3GetInt32");
    const int status = fmu ? fmu_check(fmu, FMU_WHOLE, 0, vr, count, value, values) : FMU_ERROR;
    for (size_t i = 0; i < count && status == FMU_OK; ++i) {
        value[i] = fmu->unit.whole[fmu_variables[vr[i]].place];
    }
    return (fmi3Status)status;
}

FMI3_GET(Boolean)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi3GetBoolean");
    const int status = fmu ? fmu_check(fmu, FMU_TRUTH, 0, vr, count, value, values) : FMU_ERROR;
    for (size_t i = 0; i < count && status == FMU_OK; ++i) {
        value[i] = fmu->unit.truth[fmu_variables[vr[i]].place] != 0;
    }
    return (fmi3Status)status;
}

FMI3_SET(Boolean)
{
    fmu_instance *fmu = fmu_in(c, SETTABLE, "fmi3SetBoolean");
    const int status = fmu ? fmu_check(fmu, FMU_TRUTH, 1, vr, count, value, values) : FMU_ERROR;
    for (size_t i = 0; i < count && status == FMU_OK; ++i) {
        fmu->unit.truth[fmu_variables[vr[i]].place] = value[i] ? 1 : 0;
    }
    return (fmi3Status)status;
}

/* Types that no variable has: nothing may be asked for, and that is answered. */
static fmi3Status none_3(fmi3Instance c, unsigned modes, const fmi3ValueReference *vr, size_t count, size_t values)
{
    fmu_instance *fmu = fmu_in(c, modes, "access to a type that no variable has");
    return fmu ? (fmi3Status)fmu_check(fmu, FMU_TEXT, 0, vr, count, vr, values) : fmi3Error;
}

#define NO_VARIABLE_TO_SET(type)                                                                                      \
    FMI3_SET(type)                                                                                                    \
    {                                                                                                                 \
        (void)value;                                                                                                  \
        return none_3(c, SETTABLE, vr, count, values);                                                                \
    }
#define NO_VARIABLE(type)                                                                                             \
    FMI3_GET(type)                                                                                                    \
    {                                                                                                                 \
        (void)value;                                                                                                  \
        return none_3(c, ANY, vr, count, values);                                                                     \
    }                                                                                                                 \
    NO_VARIABLE_TO_SET(type)

NO_VARIABLE_TO_SET(Int32) /* there are some, but no input */
NO_VARIABLE(Int8)
NO_VARIABLE(UInt8)
NO_VARIABLE(Int16)
NO_VARIABLE(UInt16)
NO_VARIABLE(UInt32)
NO_VARIABLE(Int64)
NO_VARIABLE(UInt64)
NO_VARIABLE(String)

FMI3_STATUS(fmi3GetBinary)(FMI3_REFERENCES, size_t size[], fmi3Binary value[], size_t values)
{
    (void)size, (void)value;
    return none_3(c, ANY, vr, count, values);
}

FMI3_STATUS(fmi3SetBinary)(FMI3_REFERENCES, const size_t size[], const fmi3Binary value[], size_t values)
{
    (void)size, (void)value;
    return none_3(c, SETTABLE, vr, count, values);
}

FMI3_STATUS(fmi3GetClock)(FMI3_REFERENCES, fmi3Clock value[])
{
    (void)value;
    return none_3(c, ANY, vr, count, count);
}

FMI3_STATUS(fmi3SetClock)(FMI3_REFERENCES, const fmi3Clock value[])
{
    (void)value;
    return none_3(c, SETTABLE, vr, count, count);
}

/* ---- State. */

FMI3_STATUS(fmi3GetFMUState)(fmi3Instance c, fmi3FMUState *state)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi3GetFMUState");
    return fmu ? (fmi3Status)fmu_keep(fmu, state) : fmi3Error;
}

FMI3_STATUS(fmi3SetFMUState)(fmi3Instance c, fmi3FMUState state)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi3SetFMUState");
    return fmu ? (fmi3Status)fmu_restore(fmu, (const fmu_image *)state) : fmi3Error;
}

FMI3_STATUS(fmi3FreeFMUState)(fmi3Instance c, fmi3FMUState *state)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi3FreeFMUState");
    return fmu ? (fmi3Status)fmu_drop(fmu, state) : fmi3Error;
}

FMI3_STATUS(fmi3SerializedFMUStateSize)(fmi3Instance c, fmi3FMUState state, size_t *size)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi3SerializedFMUStateSize");
    if (!fmu || !state || !size) {
        return fmi3Error;
    }
    *size = FMU_IMAGE_BYTES;
    return fmi3OK;
}

FMI3_STATUS(fmi3SerializeFMUState)(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi3SerializeFMUState");
    return fmu ? (fmi3Status)fmu_serialize(fmu, state, bytes, size) : fmi3Error;
}

FMI3_STATUS(fmi3DeserializeFMUState)(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi3DeserializeFMUState");
    return fmu ? (fmi3Status)fmu_deserialize(fmu, bytes, size, state) : fmi3Error;
}

/* ---- Steps. */

FMI3_STATUS(fmi3DoStep)(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean never_back,
                        fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early_return,
                        fmi3Float64 *last_time)
{
    fmu_instance *fmu = fmu_in(c, 1u << FMU_STEPPING, "fmi3DoStep");
    (void)never_back;
    if (!fmu || !event_needed || !terminate || !early_return || !last_time) {
        return fmi3Error;
    }
    const fmi3Status status = (fmi3Status)fmu_step(fmu, time, step);
    *event_needed = false;
    *terminate = false;
    *early_return = false;
    *last_time = fmu->time;
    return status;
}

/* ---- What this FMU does not have, as its model description says. */

static fmi3Status absent_3(fmi3Instance c, const char *call)
{
    fmu_instance *fmu = fmu_known(c);
    return fmu ? (fmi3Status)fmu_say(fmu, FMU_ERROR, "%s: this FMU has nothing of that kind", call) : fmi3Error;
}

#define ABSENT(name, arguments)                                                                                       \
    FMI3_STATUS(name) arguments                                                                                       \
    {                                                                                                                 \
        return absent_3(c, #name);                                                                                    \
    }

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
ABSENT(fmi3EnterEventMode, (fmi3Instance c))
ABSENT(fmi3EnterStepMode, (fmi3Instance c)) /* from event mode only: after initialization the FMU is in step mode */
ABSENT(fmi3EnterConfigurationMode, (fmi3Instance c))
ABSENT(fmi3ExitConfigurationMode, (fmi3Instance c))
ABSENT(fmi3EnterContinuousTimeMode, (fmi3Instance c))
ABSENT(fmi3EvaluateDiscreteStates, (fmi3Instance c))
ABSENT(fmi3UpdateDiscreteStates,
       (fmi3Instance c, fmi3Boolean *update, fmi3Boolean *terminate, fmi3Boolean *nominals_changed,
        fmi3Boolean *values_changed, fmi3Boolean *event_time_defined, fmi3Float64 *event_time))
ABSENT(fmi3GetNumberOfVariableDependencies, (fmi3Instance c, fmi3ValueReference vr, size_t *count))
ABSENT(fmi3GetVariableDependencies,
       (fmi3Instance c, fmi3ValueReference vr, size_t dependent_element[], fmi3ValueReference independent[],
        size_t independent_element[], fmi3DependencyKind kind[], size_t count))
ABSENT(fmi3GetDirectionalDerivative,
       (fmi3Instance c, const fmi3ValueReference unknown[], size_t unknowns, const fmi3ValueReference known[],
        size_t knowns, const fmi3Float64 seed[], size_t seeds, fmi3Float64 sensitivity[], size_t sensitivities))
ABSENT(fmi3GetAdjointDerivative,
       (fmi3Instance c, const fmi3ValueReference unknown[], size_t unknowns, const fmi3ValueReference known[],
        size_t knowns, const fmi3Float64 seed[], size_t seeds, fmi3Float64 sensitivity[], size_t sensitivities))
ABSENT(fmi3GetIntervalDecimal, (FMI3_REFERENCES, fmi3Float64 interval[], fmi3IntervalQualifier qualifier[]))
ABSENT(fmi3GetIntervalFraction,
       (FMI3_REFERENCES, fmi3UInt64 counter[], fmi3UInt64 resolution[], fmi3IntervalQualifier qualifier[]))
ABSENT(fmi3GetShiftDecimal, (FMI3_REFERENCES, fmi3Float64 shift[]))
ABSENT(fmi3GetShiftFraction, (FMI3_REFERENCES, fmi3UInt64 counter[], fmi3UInt64 resolution[]))
ABSENT(fmi3SetIntervalDecimal, (FMI3_REFERENCES, const fmi3Float64 interval[]))
ABSENT(fmi3SetIntervalFraction, (FMI3_REFERENCES, const fmi3UInt64 counter[], const fmi3UInt64 resolution[]))
ABSENT(fmi3SetShiftDecimal, (FMI3_REFERENCES, const fmi3Float64 shift[]))
ABSENT(fmi3SetShiftFraction, (FMI3_REFERENCES, const fmi3UInt64 counter[], const fmi3UInt64 resolution[]))
ABSENT(fmi3CompletedIntegratorStep,
       (fmi3Instance c, fmi3Boolean never_back, fmi3Boolean *enter_event_mode, fmi3Boolean *terminate))
ABSENT(fmi3SetTime, (fmi3Instance c, fmi3Float64 time))
ABSENT(fmi3SetContinuousStates, (fmi3Instance c, const fmi3Float64 state[], size_t count))
ABSENT(fmi3GetContinuousStateDerivatives, (fmi3Instance c, fmi3Float64 derivative[], size_t count))
ABSENT(fmi3GetEventIndicators, (fmi3Instance c, fmi3Float64 indicator[], size_t count))
ABSENT(fmi3GetContinuousStates, (fmi3Instance c, fmi3Float64 state[], size_t count))
ABSENT(fmi3GetNominalsOfContinuousStates, (fmi3Instance c, fmi3Float64 nominal[], size_t count))
ABSENT(fmi3GetNumberOfEventIndicators, (fmi3Instance c, size_t *count))
ABSENT(fmi3GetNumberOfContinuousStates, (fmi3Instance c, size_t *count))
ABSENT(fmi3GetOutputDerivatives, (FMI3_REFERENCES, const fmi3Int32 order[], fmi3Float64 value[], size_t values))
ABSENT(fmi3ActivateModelPartition, (fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time))
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif
