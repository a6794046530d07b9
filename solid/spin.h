#pragma once
/// Angular momentum of pieces that nothing holds. Every projection of a constraint is central about the positions
/// it moves, but v = (x⁺ − x)/h looks at them from the start of the substep, so a piece that turns by φ a substep
/// loses some φ²/3 of its spin. What a piece has lost is given back as a rigid rotation about its centre of mass.
#include <vector>

#include "solid/lanes.h"
#include "solid/shell.h"

namespace wick::solid {

class SpinKeeper {
 public:
  explicit SpinKeeper(const ShellMesh& mesh);

  /// Chooses the components without a pinned vertex; called once a step.
  void choose_free(const Pins& pins, const ShellInputs& inputs);

  /// Remembers the angular momentum of x and v = keep * velocity + push, at the start of a substep.
  void remember(const std::vector<Row>& position, const std::vector<Row>& velocity, const std::vector<Row>& push,
                double keep);
  /// Gives it back to `velocity` at the end of the substep, but for pieces with a vertex marked in `touched`: there
  /// the obstacles took it.
  void restore(const std::vector<Row>& position, std::vector<Row>& velocity,
               const std::vector<std::uint8_t>& touched, double h);

 private:
  struct Moments {
    double mass = 0.0;
    Vec3 first = Vec3::Zero(), momentum = Vec3::Zero(), angular = Vec3::Zero();
    Mat3 second = Mat3::Zero();
    bool touched = false;
    void add(const Moments& other);
  };
  struct Piece {
    std::size_t begin, end;              ///< vertices in order_
    std::size_t first_chunk, end_chunk;  ///< its chunks
    Vec3 origin = Vec3::Zero();          ///< where moments are taken, so that far-off sheets keep their digits
    Vec3 angular = Vec3::Zero();         ///< about the centre of mass, remembered
  };
  struct Chunk {
    std::size_t begin, end, piece;
  };
  template <class Body>
  void gather(Body&& add_vertex);
  [[nodiscard]] Moments total(const Piece& piece) const;

  std::vector<std::int32_t> order_;  ///< vertices, by component
  std::vector<std::size_t> offset_;  ///< of each component in order_
  std::vector<std::int32_t> component_;
  std::vector<Piece> pieces_;
  std::vector<Chunk> chunks_;
  std::vector<Moments> partial_;  ///< one a chunk, added in their order: the same at any thread count
  std::vector<double> mass_;
};

}  // namespace wick::solid
