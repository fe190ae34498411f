// Declarations of what src/device/openhaptics.cpp uses of the OpenHaptics HDAPI, so that it compiles in the tests. Written for
// that; values stand for themselves and are not the maker's. Never installed, never linked.
#pragma once

using HDdouble = double;
using HDint = int;
using HDenum = unsigned int;
using HDboolean = unsigned char;
using HDushort = unsigned short;
using HDerror = unsigned int;
using HHD = unsigned int;
using HDstring = const char*;
using HDSchedulerHandle = unsigned long;
using HDCallbackCode = unsigned int;

#define HDCALLBACK
#define HD_DEFAULT_DEVICE nullptr
#define HD_INVALID_HANDLE 0xFFFFFFFFu
#define HD_SUCCESS 0u
#define HD_CALLBACK_DONE 0u
#define HD_CALLBACK_CONTINUE 1u
#define HD_MAX_SCHEDULER_PRIORITY 1

enum : HDenum {
    HD_FORCE_OUTPUT = 1,
    HD_MAX_FORCE_CLAMPING,
    HD_NOMINAL_MAX_FORCE,
    HD_NOMINAL_MAX_CONTINUOUS_FORCE,
    HD_OUTPUT_DOF,
    HD_DEVICE_MODEL_TYPE,
    HD_CURRENT_TRANSFORM,
    HD_CURRENT_BUTTONS,
    HD_CURRENT_FORCE,
    HD_CURRENT_TORQUE,
};

struct HDErrorInfo {
    HDerror errorCode;
    int internalErrorCode;
    HHD hHD;
};
#define HD_DEVICE_ERROR(X) (((X).errorCode) != HD_SUCCESS)

using HDSchedulerCallback = HDCallbackCode(HDCALLBACK*)(void*);

extern "C" {
HHD hdInitDevice(HDstring name);
void hdDisableDevice(HHD device);
void hdMakeCurrentDevice(HHD device);
void hdBeginFrame(HHD device);
void hdEndFrame(HHD device);
HDErrorInfo hdGetError();
void hdEnable(HDenum what);
void hdGetDoublev(HDenum what, HDdouble* values);
void hdGetIntegerv(HDenum what, HDint* values);
HDstring hdGetString(HDenum what);
void hdSetDoublev(HDenum what, const HDdouble* values);
void hdStartScheduler();
void hdStopScheduler();
HDSchedulerHandle hdScheduleAsynchronous(HDSchedulerCallback callback, void* data, HDushort priority);
void hdUnschedule(HDSchedulerHandle handle);
}
