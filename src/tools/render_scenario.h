#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace chequer {

/// Renders the stream of a scenario file into a new recording with its truth and prints what was written.
/// @param seed instead of the file's. Throws std::runtime_error naming the file and the cause.
void RenderScenario(const std::filesystem::path& scenario, std::optional<std::uint64_t> seed,
                    const std::filesystem::path& folder);

}  // namespace chequer
