#pragma once
/// Contact of sheets with themselves and each other that never lets them pass through. What is not crossed at the
/// start of a substep is not crossed at its end: features that come near are pushed apart with friction
/// [Mueller 2007, Bridson 2002], and then every motion is certified; what cannot be certified moves as one, as in
/// rigid impact zones [Provot 1997].
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "solid/contact_pairs.h"

namespace wick {
class ParameterVisitor;
}

namespace wick::solid {

struct SheetContactParams {
  double thickness = 0.0;         ///< kept between the middles of two layers [m]; 0: that of the material
  double friction = 0.3;          ///< Coulomb coefficient of rest
  double kinetic_friction = 0.3;  ///< and of sliding
  int sweeps = 2;                 ///< over all contacts a substep
  double reach = 0.2;             ///< of the mean edge: the most that a triangle may go until pairs are found anew
};
void describe(ParameterVisitor& visitor, SheetContactParams& params);

struct SheetContactReport {
  std::size_t pairs = 0;       ///< that were watched in the last substep
  std::size_t contacts = 0;    ///< pushed apart in the last substep
  std::size_t refreshes = 0;   ///< times that clusters were paired
  std::size_t rounds = 0;      ///< of repair of uncertain motions, summed over substeps
  std::size_t stopped = 0;     ///< vertices that moved as part of a zone, summed over substeps
  std::size_t impossible = 0;  ///< pairs that what is held forces through each other, summed over substeps
};

class SheetContact {
 public:
  SheetContact(std::span<const ShellMesh* const> meshes, std::span<const double> half_thickness,
               const SheetContactParams& params);
  ~SheetContact();
  SheetContact(SheetContact&&) noexcept;
  SheetContact& operator=(SheetContact&&) noexcept;

  /// For a step of dt [s] in `substeps` parts. The rows of all sheets, one after the other: position at the start
  /// [m] and inverse mass [1/kg], 0 for what is held or driven.
  void begin_step(const std::vector<Row>& x, double dt, int substeps);

  /// Pushes apart what has come too near since the start of the substep. Marks what it moves in `touched`.
  void push_apart(std::vector<Row>& x, std::vector<std::uint8_t>& touched);

  /// Ends the substep: changes x where the way from its start cannot be certified, and marks what it moves.
  void certify(std::vector<Row>& x, std::vector<std::uint8_t>& touched);

  [[nodiscard]] SheetContactReport report() const;
  /// Vertices at which the thickness had to be lowered to what the edges of the mesh allow.
  [[nodiscard]] std::size_t lowered() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wick::solid
