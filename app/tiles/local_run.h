// An input that is too large for the memory as a whole, textured in tiles by one process.
#pragma once

#include <filesystem>
#include <string>

#include "app/results/output_folder.h"
#include "app/tiles/make_job.h"

namespace gpvc::tiles {

/// Makes a job in the folder's kept work, of tiles as large as Settings::memory_bytes (0: default_memory_limit()) allows,
/// runs its units, and writes the job's result into the folder: tileset.json, tiles/, obj/. Units that an earlier run has
/// completed are taken over, and stay where a later unit fails; with Settings::keep_work `never` the job is part of what the
/// folder has in the making, and goes with that. Throws MemoryError
/// where no tiles are small enough, and what make_job() and units throw.
void texture_in_tiles(const pipeline::Run& run, const std::string& program, results::OutputFolder& folder);

/// Removes the job that texture_in_tiles() has made in OUT, once the result is published.
void remove_job(const std::filesystem::path& out);

}  // namespace gpvc::tiles
