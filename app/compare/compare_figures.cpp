// The figures of a comparison, and what is to be known of them in sentences.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "app/compare/compare_report.h"

namespace gpvc::compare {

const std::vector<Figure>& compared_figures() {
  static const std::vector<Figure> figures{
      {"oracle.agreement", "Agreement with the oracle", "%", 3, 1,
       "Share of pairs of view and face whose class (full, partial, hidden) is that of the exact brute-force "
       "oracle; exact ties are left out."},
      {"oracle.false_full", "Falsely full", "%", 3, -1,
       "Of the pairs called fully visible, the share that are not: another surface's colour gets in."},
      {"oracle.missed_full", "Missed full", "%", 3, -1,
       "Of the pairs that are fully visible, the share not called so: good photos are not used."},
      {"truth.origin.all.right", "Textured rightly", "%", 3, 1,
       "Of the area that some used photo shows clear of any other surface, the share that takes its colour from a"
       " photo's pixel of its own surface, edges included; known for synthetic scenes, whose photos come with the"
       " surface of each pixel. What is filled from around does not count."},
      {"truth.origin.all.photo", "From a photo", "%", 3, 1,
       "Of that seen area, the share that takes its colour from any photo; the rest is filled from around."},
      {"truth.origin.all.wrong", "From another surface", "%", 4, -1,
       "Of the area textured from photos, the share whose pixel shows another surface, a pixel or more from its "
       "own in that photo."},
      {"truth.origin.all.ghost", "Ghosts where hidden", "%", 3, -1,
       "Of the area that no used photo sees, the share that is textured from a photo's pixel of another surface "
       "nevertheless: a bridge's deck painted on the ground below it."},
      {"truth.origin.all.foreign", "Foreign texture", "%", 4, -1,
       "Of all area textured from photos, seen by one or not, the share whose pixel shows another surface."},
      {"truth.origin.all.faithful", "Textured faithfully", "%", 3, 1,
       "Of all area, the share textured as it should be: where a photo sees it, from a pixel of its own surface; "
       "where none does, not from another surface's."},
      {"truth.origin.all.edge", "Blended edge", "%", 3, 0,
       "Of the area textured from photos, the share whose place in the photo lies less than a pixel from another "
       "surface, where any resampling blends; counted as right."},
      {"truth.all.textured", "Seen area textured", "%", 2, 1,
       "Of the area that some used photo shows clear of any other surface, the share with texture, filled or from"
       " a photo."},
      {"truth.all.wrong", "Wrong by colour", "%", 3, -1,
       "Of that textured area, the share whose colour is another surface's and not its own. This can be measured "
       "for any program's model; it is a lower bound where surfaces have similar colours."},
      {"score.one_minus_ncc", "1 - NCC", "", 4, -1,
       "Error of renders against photos (virtual rephotography, Waechter et al. 2017): one less the normalized "
       "cross-correlation of 11 x 11 windows."},
      {"score.ssim", "SSIM", "", 4, 1, "Structural similarity of renders and photos, 1 at best."},
      {"score.psnr_db", "PSNR", "dB", 2, 1, "Peak signal-to-noise ratio after one gain per channel."},
      {"score.completeness", "Complete", "%", 2, 1,
       "Share of the pixels covered by the mesh that the model textures, over the scored views."},
      {"visible.full", "V: full", "pairs", 0, 0,
       "Pairs of view and face called fully visible (V of the paper's tables)."},
      {"visible.partial", "Partial", "pairs", 0, 0, "Pairs called partially visible."},
      {"visible.occluded", "O: not full", "pairs", 0, 0,
       "All other pairs, partial ones included (O of the paper's tables)."},
      {"tags.seen_share", "Faces seen whole", "%", 2, 0, "Faces for which some view was found fully visible."},
      {"tags.filled_share", "Faces filled", "%", 2, 0,
       "Faces for which no view was found, filled from their neighbours."},
      {"patches", "Patches", "", 0, 0,
       "Connected groups of faces textured from one photo; for other programs' models, connected pieces of their "
       "texture. Fewer mean fewer seams."},
      {"time.visibility_s", "Visibility", "s", 2, -1,
       "Wall time of the visibility stage over all views, without costs and atlas; other work ran beside it."},
      {"time.total_s", "Texturing", "s", 1, -1,
       "Wall time of all that is done for this mode alone: visibility, costs, view selection, atlas."},
  };
  return figures;
}

std::optional<double> number_at(const Json& json, const std::string& path) {
  std::string pointer = fmt::format("/{}", path);
  std::replace(pointer.begin(), pointer.end(), '.', '/');
  const Json::json_pointer at(pointer);
  return json.contains(at) && json[at].is_number() ? std::optional(json[at].get<double>()) : std::nullopt;
}

std::string printed_figure(const std::optional<double>& value, const Figure& figure) {
  if (!value) return "";
  if (figure.digits == 0) return results::readable_count(static_cast<std::size_t>(*value));
  return fmt::format("{:.{}f}", *value * (std::string(figure.unit) == "%" ? 100 : 1), figure.digits);
}

const Json* mode_called(const Json& report, const std::string& name) {
  for (const Json& mode : report["modes"])
    if (mode["name"] == name) return &mode;
  return nullptr;
}

std::vector<std::string> findings_of(const Json& report) {
  std::vector<std::string> findings = contest_findings(report), failed;
  for (const Json& mode : report["modes"])
    if (mode["status"] != "ok") failed.push_back(mode["name"].get<std::string>());
  if (!failed.empty())
    findings.push_back(fmt::format("Failed, with what is known of them in the table: {}.", fmt::join(failed, "; ")));
  if (!report["settings"]["scored"]["held_out"].get<bool>())
    findings.push_back(
        "No view was held out: the errors are measured in views that the texture was made from, which favours modes "
        "that copy a photo back to where it came from.");
  return findings;
}

}  // namespace gpvc::compare
