// Nothing on standard output and standard error, where a finding's report belongs.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cstdio>

namespace gpvc::fuzz {

class Silence {
 public:
  Silence() {
    std::fflush(stdout);
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    for (int n = 0; n < 2; ++n) {
      kept_[static_cast<std::size_t>(n)] = dup(n + 1);
      dup2(nowhere, n + 1);
    }
    close(nowhere);
  }
  ~Silence() {
    std::fflush(stdout);
    for (int n = 0; n < 2; ++n) {
      dup2(kept_[static_cast<std::size_t>(n)], n + 1);
      close(kept_[static_cast<std::size_t>(n)]);
    }
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  std::array<int, 2> kept_{};
};

}  // namespace gpvc::fuzz
