#include "chequer/check.h"

#include <cstdio>
#include <cstdlib>

namespace chequer {

void FailCheck(const char* condition, const char* file, int line, const char* message) {
  std::fprintf(stderr, "chequer: %s:%d: %s (%s does not hold); this is a bug, please report it\n", file, line, message,
               condition);
  std::abort();
}

}  // namespace chequer
