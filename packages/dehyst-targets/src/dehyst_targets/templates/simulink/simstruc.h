/* SPDX-License-Identifier: 0BSD */
/* A stand-in for Simulink's header of this name, so that the S-function can be compiled and run without it: only what
 * the S-function of this folder uses, written from the documentation of these names. MATLAB's own header is used by
 * build_<name>.m; this one is on the path of `make check` alone. */
#ifndef SIMSTRUC_STAND_IN_H
#define SIMSTRUC_STAND_IN_H

#include <stdint.h>
#include <string.h>

typedef int int_T;
typedef double real_T;
typedef double time_T;
typedef unsigned char boolean_T;
typedef int DTypeId;

enum { SS_DOUBLE = 0, SS_SINGLE = 1, SS_UINT32 = 7, SS_BOOLEAN = 8 };
enum { COMPLEX_NO = 0, SS_DWORK_USED_AS_DSTATE = 1, USE_DEFAULT_OPERATING_POINT = 1 };
enum { SS_OPTION_EXCEPTION_FREE_CODE = 1, SS_OPTION_DISALLOW_CONSTANT_SAMPLE_TIME = 2 };
#define INHERITED_SAMPLE_TIME (-1.0)
#define FIXED_IN_MINOR_STEP_OFFSET (-1.0)
#define UNUSED_ARG(argument) (void)(argument)

enum { STAND_IN_PORTS = 4, STAND_IN_WORK = 2, STAND_IN_WIDTH = 16, STAND_IN_WORDS = 65536 };

typedef struct stand_in_port {
    int width, type, through, contiguous;
    double data[STAND_IN_WIDTH]; /* aligned for every type */
} stand_in_port;

typedef struct stand_in_work {
    int width, type, state;
    const char *name;
    uint32_t data[STAND_IN_WORDS];
} stand_in_work;

typedef struct SimStruct {
    int parameters, continuous, discrete, sample_times, options, compliance, inputs, outputs, works;
    double period, offset;
    stand_in_port input[STAND_IN_PORTS], output[STAND_IN_PORTS];
    stand_in_work work[STAND_IN_WORK];
} SimStruct;

#define ssSetNumSFcnParams(S, n) ((S)->parameters = (n))
#define ssGetNumSFcnParams(S) ((S)->parameters)
#define ssGetSFcnParamsCount(S) ((void)(S), 0)
#define ssSetNumContStates(S, n) ((S)->continuous = (n))
#define ssSetNumDiscStates(S, n) ((S)->discrete = (n))
#define ssSetNumInputPorts(S, n) ((S)->inputs = (n), (n) <= STAND_IN_PORTS)
#define ssSetNumOutputPorts(S, n) ((S)->outputs = (n), (n) <= STAND_IN_PORTS)
#define ssSetInputPortWidth(S, port, n) ((S)->input[port].width = (n))
#define ssSetInputPortDataType(S, port, t) ((S)->input[port].type = (t))
#define ssSetInputPortComplexSignal(S, port, c) ((void)(c))
#define ssSetInputPortDirectFeedThrough(S, port, yes) ((S)->input[port].through = (yes))
#define ssSetInputPortRequiredContiguous(S, port, yes) ((S)->input[port].contiguous = (yes))
#define ssSetOutputPortWidth(S, port, n) ((S)->output[port].width = (n))
#define ssSetOutputPortDataType(S, port, t) ((S)->output[port].type = (t))
#define ssSetOutputPortComplexSignal(S, port, c) ((void)(c))
#define ssSetNumSampleTimes(S, n) ((S)->sample_times = (n))
#define ssSetNumDWork(S, n) ((S)->works = (n), (n) <= STAND_IN_WORK)
#define ssSetDWorkWidth(S, k, n) ((S)->work[k].width = (n))
#define ssSetDWorkDataType(S, k, t) ((S)->work[k].type = (t))
#define ssSetDWorkName(S, k, text) ((S)->work[k].name = (text))
#define ssSetDWorkUsedAsDState(S, k, yes) ((S)->work[k].state = (yes))
#define ssSetOperatingPointCompliance(S, how) ((S)->compliance = (how))
#define ssSetOptions(S, bits) ((S)->options = (bits))
#define ssSetSampleTime(S, k, t) ((S)->period = (t))
#define ssSetOffsetTime(S, k, t) ((S)->offset = (t))
#define ssSetModelReferenceSampleTimeDefaultInheritance(S) ((void)(S))
#define ssGetDWork(S, k) ((void *)(S)->work[k].data)
#define ssGetInputPortSignal(S, port) ((const void *)(S)->input[port].data)
#define ssGetOutputPortSignal(S, port) ((void *)(S)->output[port].data)

#endif
