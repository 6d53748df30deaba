// A complete job of the tiny scene.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tiny.h"

namespace gpvc::fuzz {

/// Its folder, with job.json. Made once.
const std::filesystem::path& tiny_job();

/// A file of the job, and the units that read it.
struct JobFile {
  std::string file;
  std::vector<std::string> readers;
};

/// Calls change(path of the file), which replaces it, then runs its readers, and makes the job what it was. Each reader does its
/// work or fails with an error of ours.
int run_readers(const JobFile& file, const std::function<void(const std::filesystem::path&)>& change);

/// One for each file: its number, and `body_of` its path.
std::vector<std::string> job_seeds(std::span<const JobFile> files,
                                   std::string (*body_of)(const std::filesystem::path&));

/// Makes the hash of one of the job's files right where the job lists it.
void relist(const std::filesystem::path& file);

}  // namespace gpvc::fuzz
