// A loop whose calls write to bits of the same bytes: ThreadSanitizer must find it.
#include <tbb/parallel_for.h>

#include <cstddef>
#include <vector>

int main() {
  std::vector<bool> seen(256);
  tbb::parallel_for(std::size_t{0}, seen.size(), [&](std::size_t i) { seen[i] = true; });
}
