/* SPDX-License-Identifier: 0BSD
 *
 * Functions and types of FMI 2.0 for co-simulation, as far as this FMU has them; those of model exchange are left out. */
#ifndef DEHYST_FMI2_H
#define DEHYST_FMI2_H

#include <stddef.h>

#ifndef FMI2_Export
#if defined(_WIN32) || defined(__CYGWIN__)
#define FMI2_Export __declspec(dllexport)
#elif defined(__GNUC__)
#define FMI2_Export __attribute__((visibility("default")))
#else
#define FMI2_Export
#endif
#endif

/* Where several FMUs become one program from their sources, each has its prefix: -DFMI2_FUNCTION_PREFIX=name_ */
#ifdef FMI2_FUNCTION_PREFIX
#define FMI2_PASTE(a, b) a##b
#define FMI2_PASTED(a, b) FMI2_PASTE(a, b)
#define FMI2_NAME(name) FMI2_PASTED(FMI2_FUNCTION_PREFIX, name)
#else
#define FMI2_NAME(name) name
#endif
#define FMI2(result, name) FMI2_Export result FMI2_NAME(name)

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;

typedef void (*fmi2CallbackLogger)(fmi2ComponentEnvironment, fmi2String name, fmi2Status, fmi2String category,
                                   fmi2String message, ...);

typedef struct {
    fmi2CallbackLogger logger;
    void *(*allocateMemory)(size_t count, size_t size);
    void (*freeMemory)(void *memory);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

#ifdef __cplusplus
extern "C" {
#endif

FMI2(const char *, fmi2GetTypesPlatform)(void);
FMI2(const char *, fmi2GetVersion)(void);
FMI2(fmi2Status, fmi2SetDebugLogging)(fmi2Component, fmi2Boolean on, size_t count, const fmi2String category[]);

FMI2(fmi2Component, fmi2Instantiate)(fmi2String name, fmi2Type, fmi2String guid, fmi2String resources,
                                     const fmi2CallbackFunctions *, fmi2Boolean visible, fmi2Boolean logging);
FMI2(void, fmi2FreeInstance)(fmi2Component);
FMI2(fmi2Status, fmi2SetupExperiment)(fmi2Component, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                                      fmi2Boolean has_stop, fmi2Real stop);
FMI2(fmi2Status, fmi2EnterInitializationMode)(fmi2Component);
FMI2(fmi2Status, fmi2ExitInitializationMode)(fmi2Component);
FMI2(fmi2Status, fmi2Terminate)(fmi2Component);
FMI2(fmi2Status, fmi2Reset)(fmi2Component);

FMI2(fmi2Status, fmi2GetReal)(fmi2Component, const fmi2ValueReference[], size_t count, fmi2Real[]);
FMI2(fmi2Status, fmi2GetInteger)(fmi2Component, const fmi2ValueReference[], size_t count, fmi2Integer[]);
FMI2(fmi2Status, fmi2GetBoolean)(fmi2Component, const fmi2ValueReference[], size_t count, fmi2Boolean[]);
FMI2(fmi2Status, fmi2GetString)(fmi2Component, const fmi2ValueReference[], size_t count, fmi2String[]);
FMI2(fmi2Status, fmi2SetReal)(fmi2Component, const fmi2ValueReference[], size_t count, const fmi2Real[]);
FMI2(fmi2Status, fmi2SetInteger)(fmi2Component, const fmi2ValueReference[], size_t count, const fmi2Integer[]);
FMI2(fmi2Status, fmi2SetBoolean)(fmi2Component, const fmi2ValueReference[], size_t count, const fmi2Boolean[]);
FMI2(fmi2Status, fmi2SetString)(fmi2Component, const fmi2ValueReference[], size_t count, const fmi2String[]);

FMI2(fmi2Status, fmi2GetFMUstate)(fmi2Component, fmi2FMUstate *);
FMI2(fmi2Status, fmi2SetFMUstate)(fmi2Component, fmi2FMUstate);
FMI2(fmi2Status, fmi2FreeFMUstate)(fmi2Component, fmi2FMUstate *);
FMI2(fmi2Status, fmi2SerializedFMUstateSize)(fmi2Component, fmi2FMUstate, size_t *size);
FMI2(fmi2Status, fmi2SerializeFMUstate)(fmi2Component, fmi2FMUstate, fmi2Byte[], size_t size);
FMI2(fmi2Status, fmi2DeSerializeFMUstate)(fmi2Component, const fmi2Byte[], size_t size, fmi2FMUstate *);
FMI2(fmi2Status, fmi2GetDirectionalDerivative)(fmi2Component, const fmi2ValueReference unknown[], size_t unknowns,
                                               const fmi2ValueReference known[], size_t knowns,
                                               const fmi2Real d_known[], fmi2Real d_unknown[]);

FMI2(fmi2Status, fmi2SetRealInputDerivatives)(fmi2Component, const fmi2ValueReference[], size_t count,
                                              const fmi2Integer order[], const fmi2Real[]);
FMI2(fmi2Status, fmi2GetRealOutputDerivatives)(fmi2Component, const fmi2ValueReference[], size_t count,
                                               const fmi2Integer order[], fmi2Real[]);
FMI2(fmi2Status, fmi2DoStep)(fmi2Component, fmi2Real time, fmi2Real step, fmi2Boolean never_back);
FMI2(fmi2Status, fmi2CancelStep)(fmi2Component);
FMI2(fmi2Status, fmi2GetStatus)(fmi2Component, const fmi2StatusKind, fmi2Status *);
FMI2(fmi2Status, fmi2GetRealStatus)(fmi2Component, const fmi2StatusKind, fmi2Real *);
FMI2(fmi2Status, fmi2GetIntegerStatus)(fmi2Component, const fmi2StatusKind, fmi2Integer *);
FMI2(fmi2Status, fmi2GetBooleanStatus)(fmi2Component, const fmi2StatusKind, fmi2Boolean *);
FMI2(fmi2Status, fmi2GetStringStatus)(fmi2Component, const fmi2StatusKind, fmi2String *);

#ifdef __cplusplus
}
#endif

#endif
