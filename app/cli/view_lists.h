// Lists of views on the command line.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/cli/options.h"

namespace gpvc::cli {

/// The views that --views and --exclude-views leave. Both are lists of names and globs, or @FILE with one entry a line. A
/// name may lack its folder, extension or both if only one view then has that name; that of a panorama's photo means all
/// of its views. Throws UsageError for an entry without a view, with similar names, and for an ambiguous one.
std::vector<ViewId> used_views(std::span<const View> all, const std::string& views, const std::string& exclude_views);

/// A flag for each of `count` views, true for the given ones: the form of SceneOptions::needed.
std::vector<bool> marked(std::span<const ViewId> views, std::size_t count);

/// The views of `used` that --hold-out names: for a whole number K of at least 2 those of the K-th photo, the 2 K-th and so
/// on, else names and globs. Throws UsageError for names of no used view, and when no view would be left.
std::vector<ViewId> held_out_views(const Scene& scene, std::span<const ViewId> used, const std::string& hold_out);

/// The rules of a file that --allow names. Throws InputError, also for names of no view, as used_views() does, for faces that the
/// mesh does not have, and for coordinates that cannot be brought to the scene's.
std::vector<pipeline::ViewRule> read_rules(const std::filesystem::path& file, const checks::Input& input);

/// Names of the views that the views.json beside a model marks with `mark` ("held_out", "used"); empty where there is
/// no such file.
std::vector<std::string> marked_views(const std::filesystem::path& model, const std::string& mark);
/// Names of all views of that file, in its order.
std::vector<std::string> listed_views(const std::filesystem::path& model);
/// The poses of the views that it marks as used; empty as above.
std::vector<Pose> used_poses(const std::filesystem::path& model);

}  // namespace gpvc::cli
