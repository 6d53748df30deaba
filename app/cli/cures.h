// What a user of the command line can do about errors and warnings of the libraries: the options and commands to give.
#pragma once

#include <span>
#include <string>

#include "io/error.h"

namespace gpvc::cli {

/// A clause that names the option or command: "--keep-odd-photos textures with them all the same".
std::string clause_of(Cure cure);

/// The sentence and its cures: "SENTENCE; CLAUSE, or CLAUSE", or "QUESTION? Clause, or CLAUSE". \param of_job the run does
/// units of a job, whose options were given to the command that made it: "a job made with --keep-odd-photos textures with them
/// all the same"
std::string with_cures(const std::string& sentence, std::span<const Cure> cures, bool of_job = false);

}  // namespace gpvc::cli
