// The files of an editable result, with which retexture_into() changes a part of it: what the views see of each face, and
// how the faces are textured. Both are results as io::WorkStore keeps them, so one that is damaged or of another format is
// told from a good one. Hashes keep nobody from writing other values, so these are checked, too. They are those of this
// machine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "app/pipeline/coverage_store.h"
#include "app/pipeline/keys.h"
#include "app/pipeline/memory.h"
#include "app/pipeline/options.h"
#include "io/scene_members.h"

namespace gpvc::pipeline {

inline constexpr const char* kEditViewsFile = "edit-views.bin";
inline constexpr const char* kEditModelFile = "edit-model.bin";
/// The hashes of both once more (io::WorkStore).
inline constexpr const char* kEditHashesFile = "edit-hashes.txt";

/// How the faces of a result are textured.
struct EditModel {
  ResultKeys keys;
  std::vector<ViewRule> rules;
  std::vector<ViewId> labels;
  io::TexturedModel model;  ///< without its mesh
  std::vector<std::array<int, 2>> page_sizes;
  std::vector<std::uint32_t> face_chart;  ///< per face; numbers may have gaps
  std::vector<atlas::ViewExposure> exposure;
  std::vector<ShiftField> alignment;
  double reduction = 1;
  std::vector<io::WorkKey> page_files{};  ///< hashes of the pages as they were written
};
GPVC_MEMBERS(EditModel, keys, rules, labels, model, page_sizes, face_chart, exposure, alignment, reduction, page_files)

/// The hash of a page's file.
io::WorkKey page_file_key(const std::filesystem::path& file);

/// Write into the folder. 20 bytes for each face and view that sees it, and the coverage of those that see it in part; some 30
/// bytes a face. Throw OutputError.
void write_edit_views(const Input& input, const ResultKeys& keys, const labeling::CandidateCollector& collector,
                      const CoverageStore& coverage, OutputFolder& folder);
/// \pre the pages are written in the folder, in this format. Sets EditModel::page_files.
void write_edit_model(const Input& input, EditModel model, io::ImageFormat pages, OutputFolder& folder);

/// Throws InputError where `from` holds no editable result of this format.
EditModel read_edit_model(const std::filesystem::path& from);
/// Throws InputError where the model cannot be one of the input: a label that is no view, a face on no page unless some `may_lack_pages`,
/// as those of a given layout may. O(faces).
void check_edit_model(const std::filesystem::path& from, const Input& input, const EditModel& model,
                      bool may_lack_pages);
/// Adds all views, and takes over how they were judged. Throws InputError.
void read_edit_views(const std::filesystem::path& from, const Input& input, const ResultKeys& keys,
                     labeling::CandidateCollector& collector, CoverageStore& coverage);
/// Writes the views of `from` into the folder. Throws InputError, OutputError.
void copy_edit_views(const std::filesystem::path& from, const ResultKeys& keys, OutputFolder& folder);

/// Bytes of both files, predicted.
double edit_bytes(const Workload& work);

}  // namespace gpvc::pipeline
