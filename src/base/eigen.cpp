#define PAVE_COMPILED_ELSEWHERE
#include "base/eigen.h"
