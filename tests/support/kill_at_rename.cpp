// Loaded into gpvc by tests/faults.sh: kills it before the change of a name whose number KILL_AT_RENAME says, counted from
// the first one by which publishing begins.
#include <fcntl.h>
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

namespace {

long left = -1;  ///< steps; -1: publishing has not begun

void step(const char* new_name) {
  if (left < 0) {
    // Files that are finished one by one are renamed from a name with ".part-"; publishing begins with its journal.
    if (std::strstr(new_name, "publish") == nullptr) return;
    const char* at = std::getenv("KILL_AT_RENAME");
    left = at == nullptr ? 1000000 : std::atol(at);
  }
  if (left-- == 0) kill(getpid(), SIGKILL);
}

}  // namespace

extern "C" int renameat2(int from, const char* name, int to, const char* new_name, unsigned flags) noexcept {
  step(new_name);
  return static_cast<int>(syscall(SYS_renameat2, from, name, to, new_name, flags));
}
extern "C" int renameat(int from, const char* name, int to, const char* new_name) noexcept {
  return renameat2(from, name, to, new_name, 0U);
}
extern "C" int rename(const char* name, const char* new_name) noexcept {
  step(new_name);
  return static_cast<int>(syscall(SYS_renameat2, AT_FDCWD, name, AT_FDCWD, new_name, 0U));
}
extern "C" int unlinkat(int folder, const char* name, int flags) noexcept {
  step("");
  return static_cast<int>(syscall(SYS_unlinkat, folder, name, flags));
}
