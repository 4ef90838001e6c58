#include "world/references.h"

#include <limits>
#include <numbers>

#include "core/toml_reader.h"
#include "world/world_file.h"

namespace chequer {
namespace {

constexpr NumberRange kFloorPlace{-1000, 1000};
/// Nearer than that, two boards would lie over each other.
constexpr double kSamePlaceM = 0.001;

Reference ReadPlacedMarker(TomlTable& table) {
  Reference reference;
  table.Require("id", reference.id, IntegerRange{0, std::numeric_limits<std::int64_t>::max()});
  table.Read("family", reference.family, IntegerRange{0, 63});
  std::vector<double> position;
  if (!table.ReadLengths("position", position, LengthRange{2, 3}, kFloorPlace)) table.FailMissing("position");
  reference.position_in_world = {position[0], position[1], position.size() == 3 ? position[2] : 0};
  table.Read("lies_flat", reference.lies_flat);
  double heading_deg = 0;
  if (table.Read("heading", heading_deg, NumberRange{-360, 360}))
    reference.heading_rad = heading_deg * std::numbers::pi / 180;
  if (reference.heading_rad && !reference.lies_flat)
    table.Fail("heading", "is only for boards that lie flat; leave it out with lies_flat = false");
  return reference;
}

void CheckAgainst(const std::vector<Reference>& others, const Reference& reference, const TomlTable& table) {
  for (const Reference& other : others) {
    if (other.id == reference.id && other.family == reference.family)
      table.Fail("id", "stands twice; each reference must be a marker of its own");
    if ((other.position_in_world - reference.position_in_world).norm() < kSamePlaceM)
      table.Fail("position", "is also that of reference " + std::to_string(other.id) + "; one of them must be wrong");
  }
}

ReferenceList ReadReferences(TomlFile file) {
  ReferenceList list;
  TomlTable root = file.root();
  root.ReadLength("sigma", list.sigma_m, NumberRange{1e-6, 1});
  for (TomlTable& table : root.Tables("reference", kMaxReferences)) {
    const Reference reference = ReadPlacedMarker(table);
    CheckAgainst(list.references, reference, table);
    list.references.push_back(reference);
  }
  file.CheckAllKeysRead();
  if (list.references.empty())
    root.Fail("reference", "is missing: each marker at a known place needs a [[reference]] with id and position");
  return list;
}

}  // namespace

ReferenceList LoadReferences(const std::filesystem::path& path) { return ReadReferences(TomlFile::Load(path)); }

ReferenceList ParseReferences(std::string_view text, const std::string& name) {
  return ReadReferences(TomlFile::Parse(text, name));
}

}  // namespace chequer
