#include "sqmap/device/device.h"
