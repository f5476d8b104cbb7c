/* SPDX-License-Identifier: 0BSD
 *
 * FMI 2.0, co-simulation. Included by all.c, after unit.h and fmu.h. */
#include "fmi2.h"

#define ANY ((1u << FMU_INSTANTIATED) | (1u << FMU_INITIALIZING) | (1u << FMU_STEPPING) | (1u << FMU_TERMINATED))
#define SETTABLE ((1u << FMU_INSTANTIATED) | (1u << FMU_INITIALIZING) | (1u << FMU_STEPPING))

static void say_2(const fmu_instance *fmu, int status, const char *category, const char *message)
{
    fmi2CallbackLogger logger = (fmi2CallbackLogger)fmu->log;
    logger(fmu->environment, fmu->name, (fmi2Status)status, category, "%s", message);
}

FMI2(const char *, fmi2GetTypesPlatform)(void)
{
    return "default";
}

FMI2(const char *, fmi2GetVersion)(void)
{
    return "2.0";
}

FMI2(fmi2Status, fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String category[])
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi2SetDebugLogging");
    return fmu ? (fmi2Status)fmu_log_categories(fmu, on, count, category) : fmi2Error;
}

/* ---- Life. */

FMI2(fmi2Component, fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                     const fmi2CallbackFunctions *host, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)resources, (void)visible;
    if (!host || !name || !*name) {
        return NULL;
    }
    if (type != fmi2CoSimulation || !guid || strcmp(guid, FMU_TOKEN) != 0) {
        if (host->logger) {
            host->logger(host->componentEnvironment, name, fmi2Error, fmu_category[FMU_ERROR], "%s",
                         type != fmi2CoSimulation ? "this FMU is for co-simulation only"
                                                  : "the GUID is not " FMU_TOKEN ": description and binary differ");
        }
        return NULL;
    }
    void *(*allocate)(size_t, size_t) = host->allocateMemory && host->freeMemory ? host->allocateMemory : calloc;
    fmu_instance *fmu = (fmu_instance *)allocate(1, sizeof *fmu);
    if (!fmu) {
        return NULL;
    }
    memset(fmu, 0, sizeof *fmu);
    fmu->allocate = allocate;
    fmu->release = allocate == calloc ? free : host->freeMemory;
    fmu->environment = host->componentEnvironment;
    fmu->log = (void (*)(void))host->logger;
    fmu->say = say_2;
    fmu_made(fmu, name, logging);
    return fmu;
}

FMI2(void, fmi2FreeInstance)(fmi2Component c)
{
    fmu_instance *fmu = fmu_known(c);
    if (fmu) {
        fmu->magic = 0;
        fmu->release(fmu);
    }
}

FMI2(fmi2Status, fmi2SetupExperiment)(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                                      fmi2Boolean has_stop, fmi2Real stop)
{
    fmu_instance *fmu = fmu_in(c, 1u << FMU_INSTANTIATED, "fmi2SetupExperiment");
    (void)has_tolerance, (void)tolerance;
    return fmu ? (fmi2Status)fmu_set_times(fmu, start, has_stop, stop) : fmi2Error;
}

FMI2(fmi2Status, fmi2EnterInitializationMode)(fmi2Component c)
{
    fmu_instance *fmu = fmu_in(c, 1u << FMU_INSTANTIATED, "fmi2EnterInitializationMode");
    if (!fmu) {
        return fmi2Error;
    }
    fmu->mode = FMU_INITIALIZING;
    return fmi2OK;
}

FMI2(fmi2Status, fmi2ExitInitializationMode)(fmi2Component c)
{
    fmu_instance *fmu = fmu_in(c, 1u << FMU_INITIALIZING, "fmi2ExitInitializationMode");
    return fmu ? (fmi2Status)fmu_go(fmu) : fmi2Error;
}

FMI2(fmi2Status, fmi2Terminate)(fmi2Component c)
{
    fmu_instance *fmu = fmu_in(c, 1u << FMU_STEPPING, "fmi2Terminate");
    if (!fmu) {
        return fmi2Error;
    }
    fmu->mode = FMU_TERMINATED;
    return fmi2OK;
}

FMI2(fmi2Status, fmi2Reset)(fmi2Component c)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi2Reset");
    if (!fmu) {
        return fmi2Error;
    }
    fmu_begin(fmu);
    return fmi2OK;
}

/* ---- Variables. */

FMI2(fmi2Status, fmi2GetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2Real value[])
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi2GetReal");
    return fmu ? (fmi2Status)fmu_get_real(fmu, FMU_REAL, vr, count, value, count) : fmi2Error;
}

FMI2(fmi2Status, fmi2GetInteger)(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2Integer value[])
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi2GetInteger");
    const int status = fmu ? fmu_check(fmu, FMU_WHOLE, 0, vr, count, value, count) : FMU_ERROR;
    for (size_t i = 0; i < count && status == FMU_OK; ++i) {
        value[i] = fmu->unit.whole[fmu_variables[vr[i]].place];
    }
    return (fmi2Status)status;
}

FMI2(fmi2Status, fmi2GetBoolean)(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2Boolean value[])
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi2GetBoolean");
    const int status = fmu ? fmu_check(fmu, FMU_TRUTH, 0, vr, count, value, count) : FMU_ERROR;
    for (size_t i = 0; i < count && status == FMU_OK; ++i) {
        value[i] = fmu->unit.truth[fmu_variables[vr[i]].place];
    }
    return (fmi2Status)status;
}

FMI2(fmi2Status, fmi2GetString)(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2String value[])
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi2GetString");
    return fmu ? (fmi2Status)fmu_check(fmu, FMU_TEXT, 0, vr, count, value, count) : fmi2Error;
}

FMI2(fmi2Status, fmi2SetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t count, const fmi2Real value[])
{
    fmu_instance *fmu = fmu_in(c, SETTABLE, "fmi2SetReal");
    return fmu ? (fmi2Status)fmu_set_real(fmu, FMU_REAL, vr, count, value, count) : fmi2Error;
}

FMI2(fmi2Status, fmi2SetInteger)(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                 const fmi2Integer value[])
{
    fmu_instance *fmu = fmu_in(c, SETTABLE, "fmi2SetInteger"); /* no input is one */
    return fmu ? (fmi2Status)fmu_check(fmu, FMU_WHOLE, 1, vr, count, value, count) : fmi2Error;
}

FMI2(fmi2Status, fmi2SetBoolean)(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                 const fmi2Boolean value[])
{
    fmu_instance *fmu = fmu_in(c, SETTABLE, "fmi2SetBoolean");
    const int status = fmu ? fmu_check(fmu, FMU_TRUTH, 1, vr, count, value, count) : FMU_ERROR;
    for (size_t i = 0; i < count && status == FMU_OK; ++i) {
        fmu->unit.truth[fmu_variables[vr[i]].place] = value[i] != 0;
    }
    return (fmi2Status)status;
}

FMI2(fmi2Status, fmi2SetString)(fmi2Component c, const fmi2ValueReference vr[], size_t count, const fmi2String value[])
{
    fmu_instance *fmu = fmu_in(c, SETTABLE, "fmi2SetString");
    return fmu ? (fmi2Status)fmu_check(fmu, FMU_TEXT, 1, vr, count, value, count) : fmi2Error;
}

/* ---- State. */

FMI2(fmi2Status, fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi2GetFMUstate");
    return fmu ? (fmi2Status)fmu_keep(fmu, state) : fmi2Error;
}

FMI2(fmi2Status, fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate state)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi2SetFMUstate");
    return fmu ? (fmi2Status)fmu_restore(fmu, (const fmu_image *)state) : fmi2Error;
}

FMI2(fmi2Status, fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi2FreeFMUstate");
    return fmu ? (fmi2Status)fmu_drop(fmu, state) : fmi2Error;
}

FMI2(fmi2Status, fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi2SerializedFMUstateSize");
    if (!fmu || !state || !size) {
        return fmi2Error;
    }
    *size = FMU_IMAGE_BYTES;
    return fmi2OK;
}

FMI2(fmi2Status, fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi2SerializeFMUstate");
    return fmu ? (fmi2Status)fmu_serialize(fmu, state, bytes, size) : fmi2Error;
}

FMI2(fmi2Status, fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi2DeSerializeFMUstate");
    return fmu ? (fmi2Status)fmu_deserialize(fmu, bytes, size, state) : fmi2Error;
}

/* ---- Steps. */

FMI2(fmi2Status, fmi2DoStep)(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean never_back)
{
    fmu_instance *fmu = fmu_in(c, 1u << FMU_STEPPING, "fmi2DoStep");
    (void)never_back;
    return fmu ? (fmi2Status)fmu_step(fmu, time, step) : fmi2Error;
}

FMI2(fmi2Status, fmi2GetRealStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi2GetRealStatus");
    if (!fmu || !value) {
        return fmi2Error;
    }
    if (kind != fmi2LastSuccessfulTime) {
        return fmi2Discard;
    }
    *value = fmu->time;
    return fmi2OK;
}

FMI2(fmi2Status, fmi2GetBooleanStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    fmu_instance *fmu = fmu_in(c, ANY, "fmi2GetBooleanStatus");
    if (!fmu || !value) {
        return fmi2Error;
    }
    if (kind != fmi2Terminated) {
        return fmi2Discard;
    }
    *value = 0;
    return fmi2OK;
}

FMI2(fmi2Status, fmi2GetStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind; /* no step is ever pending */
    return fmu_in(c, ANY, "fmi2GetStatus") && value ? fmi2Discard : fmi2Error;
}

FMI2(fmi2Status, fmi2GetIntegerStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind;
    return fmu_in(c, ANY, "fmi2GetIntegerStatus") && value ? fmi2Discard : fmi2Error;
}

FMI2(fmi2Status, fmi2GetStringStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind;
    return fmu_in(c, ANY, "fmi2GetStringStatus") && value ? fmi2Discard : fmi2Error;
}

/* ---- What this FMU does not have, as its model description says. */

static fmi2Status absent_2(fmi2Component c, const char *call)
{
    fmu_instance *fmu = fmu_known(c);
    return fmu ? (fmi2Status)fmu_say(fmu, FMU_ERROR, "%s: this FMU has nothing of that kind", call) : fmi2Error;
}

FMI2(fmi2Status, fmi2CancelStep)(fmi2Component c)
{
    return absent_2(c, "fmi2CancelStep");
}

FMI2(fmi2Status, fmi2GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
                                               const fmi2ValueReference known[], size_t knowns,
                                               const fmi2Real d_known[], fmi2Real d_unknown[])
{
    (void)unknown, (void)unknowns, (void)known, (void)knowns, (void)d_known, (void)d_unknown;
    return absent_2(c, "fmi2GetDirectionalDerivative");
}

FMI2(fmi2Status, fmi2SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                              const fmi2Integer order[], const fmi2Real value[])
{
    (void)vr, (void)count, (void)order, (void)value;
    return absent_2(c, "fmi2SetRealInputDerivatives");
}

FMI2(fmi2Status, fmi2GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                               const fmi2Integer order[], fmi2Real value[])
{
    (void)vr, (void)count, (void)order, (void)value;
    return absent_2(c, "fmi2GetRealOutputDerivatives");
}
