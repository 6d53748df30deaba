#include "app/cli/cures.h"

#include <cctype>

namespace gpvc::cli {

// Clauses that begin with an option speak of what the run does with it.
std::string clause_of(Cure cure) {
  switch (cure) {
    case Cure::keep_odd_views:
      return "--keep-odd-photos textures with them all the same";
    case Cure::allow_misfit:
      return "--allow-misfit textures all the same";
    case Cure::allow_unseen:
      return "--allow-unseen textures all the same";
    case Cure::look_at_fit:
      return "see gpvc inspect --check --picture";
    case Cure::name_mesh_crs:
      return "name the mesh's reference system by --mesh-crs EPSG:NUMBER";
    case Cure::more_memory:
      return "free some, or allow another amount by --memory SIZE";
    case Cure::limit_memory:
      return "keep it below an amount by --memory SIZE";
    case Cure::skip_bad_photos:
      return "--skip-bad-photos goes on without them";
    case Cure::keep_background:
      return "--background none keeps them";
    case Cure::photos_folder:
      return "name the folder of the photos by --images DIR";
    case Cure::smaller_photos:
      return "lower what it needs by --downscale 2";
    case Cure::fewer_views:
      return "texture from fewer --views";
    case Cure::fewer_faces:
      return "take a mesh of fewer faces";
    case Cure::more_bytes:
      return "allow more by --max-bytes SIZE";
    case Cure::other_folder:
      return "choose another folder";
    case Cure::replace_result:
      return "give --force to replace it when the new one is complete";
    case Cure::bands_as_tiff:
      return "take TIFFs for them by --band-format tif";
    case Cure::make_editable:
      return "texture it again with --editable";
    case Cure::make_job:
      return "make the job by gpvc tiles";
    case Cure::smaller_tiles:
      return "make the job with fewer --tile-faces";
    case Cure::fewer_unit_views:
      return "make the job with fewer --unit-views";
    case Cure::synthesize:
      return "gpvc synth makes one";
  }
  return {};
}

std::string with_cures(const std::string& sentence, std::span<const Cure> cures, bool of_job) {
  std::string advice;
  for (const Cure cure : cures) {
    const std::string clause = clause_of(cure);
    if (!advice.empty()) advice += ", or ";
    advice += of_job && clause.starts_with("--") ? "a job made with " + clause : clause;
  }
  if (advice.empty()) return sentence;
  if (!sentence.ends_with('?')) return sentence + "; " + advice;
  advice[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(advice[0])));
  return sentence + ' ' + advice;
}

}  // namespace gpvc::cli
