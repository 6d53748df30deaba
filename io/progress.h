// How stages that take long report their progress.
#pragma once

#include <cstddef>
#include <functional>

namespace gpvc {

/// Called by long stages with units done and their total, from any one thread at a time. May throw Cancelled, which the
/// stage lets through after leaving nothing half-written.
using Progress = std::function<void(std::size_t done, std::size_t total)>;

}  // namespace gpvc
