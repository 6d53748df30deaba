// Memory that is given back when it is needed no longer.
#include "io/freed_memory.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace gpvc {

void release_freed_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace gpvc
