// The views that a user names on the command line.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "app/cli/options.h"

namespace gpvc::cli {

/// Which views LISTs of names and globs, or @FILE, leave; a name may lack its extension where one view alone has it
/// without. Throws UsageError for an entry that matches none, with the names that come near, and for a name without
/// extension that two views have.
std::vector<ViewId> used_views(std::span<const View> all, const std::string& views, const std::string& exclude_views);

/// For SceneOptions::needed: those of used_views.
std::function<std::vector<bool>(std::span<const View>)> needs_used_views(std::string views, std::string exclude_views);

/// Which of `used` a --hold-out names: every K-th (the K-th, the 2 K-th, ...) for a whole number from 2, else names and
/// globs. Throws UsageError for names among none of them, and when nothing would be left.
std::vector<ViewId> held_out_views(const Scene& scene, std::span<const ViewId> used, const std::string& hold_out);

/// Names of the views that the views.json beside a model marks with `mark` ("held_out", "used"); empty where there is
/// no such file.
std::vector<std::string> marked_views(const std::filesystem::path& model, const std::string& mark);

}  // namespace gpvc::cli
