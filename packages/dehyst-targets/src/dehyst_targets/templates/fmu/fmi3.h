/* SPDX-License-Identifier: 0BSD
 *
 * Functions and types of FMI 3.0: all 75 functions, because importers look for each of them. */
#ifndef DEHYST_FMI3_H
#define DEHYST_FMI3_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifndef FMI3_Export
#if defined(_WIN32) || defined(__CYGWIN__)
#define FMI3_Export __declspec(dllexport)
#elif defined(__GNUC__)
#define FMI3_Export __attribute__((visibility("default")))
#else
#define FMI3_Export
#endif
#endif

/* Where several FMUs become one program from their sources, each has its prefix: -DFMI3_FUNCTION_PREFIX=name_ */
#ifdef FMI3_FUNCTION_PREFIX
#define FMI3_PASTE(a, b) a##b
#define FMI3_PASTED(a, b) FMI3_PASTE(a, b)
#define FMI3_NAME(name) FMI3_PASTED(FMI3_FUNCTION_PREFIX, name)
#else
#define FMI3_NAME(name) name
#endif
#define FMI3(result, name) FMI3_Export result FMI3_NAME(name)
#define FMI3_STATUS(name) FMI3(fmi3Status, name)

typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean;
typedef bool fmi3Clock;
typedef const char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum {
    fmi3Independent,
    fmi3Constant,
    fmi3Fixed,
    fmi3Tunable,
    fmi3Discrete,
    fmi3Dependent
} fmi3DependencyKind;
typedef enum { fmi3IntervalNotYetKnown, fmi3IntervalUnchanged, fmi3IntervalChanged } fmi3IntervalQualifier;

typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String category, fmi3String message);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64 time, fmi3Boolean set_requested,
                                               fmi3Boolean get_allowed, fmi3Boolean finished, fmi3Boolean can_return,
                                               fmi3Boolean *return_requested, fmi3Float64 *return_time);
typedef void (*fmi3LockPreemptionCallback)(void);
typedef void (*fmi3UnlockPreemptionCallback)(void);

#define FMI3_REFERENCES fmi3Instance c, const fmi3ValueReference vr[], size_t count
#define FMI3_GET(type) FMI3_STATUS(fmi3Get##type)(FMI3_REFERENCES, fmi3##type value[], size_t values)
#define FMI3_SET(type) FMI3_STATUS(fmi3Set##type)(FMI3_REFERENCES, const fmi3##type value[], size_t values)

#ifdef __cplusplus
extern "C" {
#endif

FMI3(const char *, fmi3GetVersion)(void);
FMI3_STATUS(fmi3SetDebugLogging)(fmi3Instance, fmi3Boolean on, size_t count, const fmi3String category[]);

FMI3(fmi3Instance, fmi3InstantiateModelExchange)(fmi3String name, fmi3String token, fmi3String resources,
                                                 fmi3Boolean visible, fmi3Boolean logging, fmi3InstanceEnvironment,
                                                 fmi3LogMessageCallback);
FMI3(fmi3Instance, fmi3InstantiateCoSimulation)(fmi3String name, fmi3String token, fmi3String resources,
                                                fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean event_mode,
                                                fmi3Boolean early_return, const fmi3ValueReference intermediate[],
                                                size_t intermediates, fmi3InstanceEnvironment, fmi3LogMessageCallback,
                                                fmi3IntermediateUpdateCallback);
FMI3(fmi3Instance, fmi3InstantiateScheduledExecution)(fmi3String name, fmi3String token, fmi3String resources,
                                                      fmi3Boolean visible, fmi3Boolean logging,
                                                      fmi3InstanceEnvironment, fmi3LogMessageCallback,
                                                      fmi3ClockUpdateCallback, fmi3LockPreemptionCallback,
                                                      fmi3UnlockPreemptionCallback);
FMI3(void, fmi3FreeInstance)(fmi3Instance);
FMI3_STATUS(fmi3EnterInitializationMode)(fmi3Instance, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                         fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop);
FMI3_STATUS(fmi3ExitInitializationMode)(fmi3Instance);
FMI3_STATUS(fmi3EnterEventMode)(fmi3Instance);
FMI3_STATUS(fmi3Terminate)(fmi3Instance);
FMI3_STATUS(fmi3Reset)(fmi3Instance);

FMI3_GET(Float32);
FMI3_GET(Float64);
FMI3_GET(Int8);
FMI3_GET(UInt8);
FMI3_GET(Int16);
FMI3_GET(UInt16);
FMI3_GET(Int32);
FMI3_GET(UInt32);
FMI3_GET(Int64);
FMI3_GET(UInt64);
FMI3_GET(Boolean);
FMI3_GET(String);
FMI3_STATUS(fmi3GetBinary)(FMI3_REFERENCES, size_t size[], fmi3Binary value[], size_t values);
FMI3_STATUS(fmi3GetClock)(FMI3_REFERENCES, fmi3Clock value[]);
FMI3_SET(Float32);
FMI3_SET(Float64);
FMI3_SET(Int8);
FMI3_SET(UInt8);
FMI3_SET(Int16);
FMI3_SET(UInt16);
FMI3_SET(Int32);
FMI3_SET(UInt32);
FMI3_SET(Int64);
FMI3_SET(UInt64);
FMI3_SET(Boolean);
FMI3_SET(String);
FMI3_STATUS(fmi3SetBinary)(FMI3_REFERENCES, const size_t size[], const fmi3Binary value[], size_t values);
FMI3_STATUS(fmi3SetClock)(FMI3_REFERENCES, const fmi3Clock value[]);

FMI3_STATUS(fmi3GetNumberOfVariableDependencies)(fmi3Instance, fmi3ValueReference, size_t *count);
FMI3_STATUS(fmi3GetVariableDependencies)(fmi3Instance, fmi3ValueReference dependent, size_t dependent_element[],
                                         fmi3ValueReference independent[], size_t independent_element[],
                                         fmi3DependencyKind kind[], size_t count);

FMI3_STATUS(fmi3GetFMUState)(fmi3Instance, fmi3FMUState *);
FMI3_STATUS(fmi3SetFMUState)(fmi3Instance, fmi3FMUState);
FMI3_STATUS(fmi3FreeFMUState)(fmi3Instance, fmi3FMUState *);
FMI3_STATUS(fmi3SerializedFMUStateSize)(fmi3Instance, fmi3FMUState, size_t *size);
FMI3_STATUS(fmi3SerializeFMUState)(fmi3Instance, fmi3FMUState, fmi3Byte[], size_t size);
FMI3_STATUS(fmi3DeserializeFMUState)(fmi3Instance, const fmi3Byte[], size_t size, fmi3FMUState *);
FMI3_STATUS(fmi3GetDirectionalDerivative)(fmi3Instance, const fmi3ValueReference unknown[], size_t unknowns,
                                          const fmi3ValueReference known[], size_t knowns, const fmi3Float64 seed[],
                                          size_t seeds, fmi3Float64 sensitivity[], size_t sensitivities);
FMI3_STATUS(fmi3GetAdjointDerivative)(fmi3Instance, const fmi3ValueReference unknown[], size_t unknowns,
                                      const fmi3ValueReference known[], size_t knowns, const fmi3Float64 seed[],
                                      size_t seeds, fmi3Float64 sensitivity[], size_t sensitivities);

FMI3_STATUS(fmi3EnterConfigurationMode)(fmi3Instance);
FMI3_STATUS(fmi3ExitConfigurationMode)(fmi3Instance);
FMI3_STATUS(fmi3GetIntervalDecimal)(FMI3_REFERENCES, fmi3Float64 interval[], fmi3IntervalQualifier[]);
FMI3_STATUS(fmi3GetIntervalFraction)(FMI3_REFERENCES, fmi3UInt64 counter[], fmi3UInt64 resolution[],
                                     fmi3IntervalQualifier[]);
FMI3_STATUS(fmi3GetShiftDecimal)(FMI3_REFERENCES, fmi3Float64 shift[]);
FMI3_STATUS(fmi3GetShiftFraction)(FMI3_REFERENCES, fmi3UInt64 counter[], fmi3UInt64 resolution[]);
FMI3_STATUS(fmi3SetIntervalDecimal)(FMI3_REFERENCES, const fmi3Float64 interval[]);
FMI3_STATUS(fmi3SetIntervalFraction)(FMI3_REFERENCES, const fmi3UInt64 counter[], const fmi3UInt64 resolution[]);
FMI3_STATUS(fmi3SetShiftDecimal)(FMI3_REFERENCES, const fmi3Float64 shift[]);
FMI3_STATUS(fmi3SetShiftFraction)(FMI3_REFERENCES, const fmi3UInt64 counter[], const fmi3UInt64 resolution[]);
FMI3_STATUS(fmi3EvaluateDiscreteStates)(fmi3Instance);
FMI3_STATUS(fmi3UpdateDiscreteStates)(fmi3Instance, fmi3Boolean *update, fmi3Boolean *terminate,
                                      fmi3Boolean *nominals_changed, fmi3Boolean *values_changed,
                                      fmi3Boolean *event_time_defined, fmi3Float64 *event_time);

FMI3_STATUS(fmi3EnterContinuousTimeMode)(fmi3Instance);
FMI3_STATUS(fmi3CompletedIntegratorStep)(fmi3Instance, fmi3Boolean never_back, fmi3Boolean *enter_event_mode,
                                         fmi3Boolean *terminate);
FMI3_STATUS(fmi3SetTime)(fmi3Instance, fmi3Float64 time);
FMI3_STATUS(fmi3SetContinuousStates)(fmi3Instance, const fmi3Float64 state[], size_t count);
FMI3_STATUS(fmi3GetContinuousStateDerivatives)(fmi3Instance, fmi3Float64 derivative[], size_t count);
FMI3_STATUS(fmi3GetEventIndicators)(fmi3Instance, fmi3Float64 indicator[], size_t count);
FMI3_STATUS(fmi3GetContinuousStates)(fmi3Instance, fmi3Float64 state[], size_t count);
FMI3_STATUS(fmi3GetNominalsOfContinuousStates)(fmi3Instance, fmi3Float64 nominal[], size_t count);
FMI3_STATUS(fmi3GetNumberOfEventIndicators)(fmi3Instance, size_t *count);
FMI3_STATUS(fmi3GetNumberOfContinuousStates)(fmi3Instance, size_t *count);

FMI3_STATUS(fmi3EnterStepMode)(fmi3Instance);
FMI3_STATUS(fmi3GetOutputDerivatives)(FMI3_REFERENCES, const fmi3Int32 order[], fmi3Float64 value[], size_t values);
FMI3_STATUS(fmi3DoStep)(fmi3Instance, fmi3Float64 time, fmi3Float64 step, fmi3Boolean never_back,
                        fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early_return,
                        fmi3Float64 *last_time);
FMI3_STATUS(fmi3ActivateModelPartition)(fmi3Instance, fmi3ValueReference clock, fmi3Float64 time);

#ifdef __cplusplus
}
#endif

#endif
