#pragma once
/// Writes and reads one walked state as an HDF5 image.
#include "scenes/checkpoint.h"
#include "scenes/hdf5_image.h"

namespace wick::test {

inline void write_state(scenes::Hdf5Writer& writer, FunctionRef<void(StateVisitor&)> visit) {
  scenes::StateWriter visitor(writer, "/state");
  visit(visitor);
}

inline void read_state(const scenes::Bytes& bytes, FunctionRef<void(StateVisitor&)> visit) {
  const scenes::Hdf5Reader reader(bytes);
  scenes::StateReader visitor(reader, "/state");
  visit(visitor);
}

}  // namespace wick::test
