// SPDX-License-Identifier: GPL-3.0-or-later
// The errors that end a stage. Imperfect data that a stage can count and go on with is no error.
#pragma once

#include <exception>
#include <stdexcept>
#include <string>
#include <utility>

namespace cornice {

/// Exit codes of every executable.
enum class ExitCode : int { kDone = 0, kFailed = 1, kUsage = 2, kBadInput = 3 };

/// Ends a stage. what() is one line, "SUBJECT: what is wrong, where, what to do".
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, std::string subject, std::string problem)
      : std::runtime_error(subject.empty() ? problem : subject + ": " + problem),
        code_(code),
        subject_(std::move(subject)),
        problem_(std::move(problem)) {}

  ExitCode code() const { return code_; }
  /// File, option or tile that the error is about; may be empty.
  const std::string& subject() const { return subject_; }
  const std::string& problem() const { return problem_; }

 private:
  ExitCode code_;
  std::string subject_;
  std::string problem_;
};

/// Input that cannot be used: exit 3.
class InputError : public Error {
 public:
  InputError(std::string file, std::string problem)
      : Error(ExitCode::kBadInput, std::move(file), std::move(problem)) {}
};

/// Wrong options or configuration: exit 2.
class UsageError : public Error {
 public:
  UsageError(std::string option, std::string problem)
      : Error(ExitCode::kUsage, std::move(option), std::move(problem)) {}
};

/// Something failed while running (disk full, out of memory): exit 1.
class RunError : public Error {
 public:
  RunError(std::string subject, std::string problem)
      : Error(ExitCode::kFailed, std::move(subject), std::move(problem)) {}
};

/// Work was stopped from outside (Progress::cancelled() was true): no error of its own kind. The
/// executable exits with 128 + the signal's number.
class Cancelled : public std::exception {
 public:
  const char* what() const noexcept override { return "stopped before it was done"; }
};

}  // namespace cornice
