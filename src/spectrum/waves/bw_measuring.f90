module bw_measuring
  !! What a measurement of waves is told beside the samples.
  use bw_kinds, only: dp
  implicit none (type, external)
  private

  type, public :: known_modes
    !! The modes that make up a record, from the first on.
    real(dp), allocatable :: angular_frequency(:)  !! rad/s, ascending; 0 of a mode that does not oscillate, (mode)
    logical :: all = .true.                        !! false: there are others above these
  end type known_modes

  type, public :: measuring_type
    real(dp) :: duration = 1                   !! of the record, T > 0, s
    real(dp) :: length = 1                     !! of the beam, > 0, m
    integer :: max_peaks = 20                  !! ≥ 0
    logical :: uniform = .true.                !! Eqs 18 to 20 hold; otherwise wave numbers and velocities are missing
    type(known_modes), allocatable :: known    !! to check what was measured; unallocated: not known
  end type measuring_type

end module bw_measuring
