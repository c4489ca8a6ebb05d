module bw_tension_source
  !! Modes of a beam of pieces with tension by their numbers: as many as were solved for, and how amplitudes fall beyond them.
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set, mode_source
  use bw_monitor, only: monitor_type
  use bw_piece_strains, only: piece_motions
  use bw_piece_tension, only: tension_in_pieces
  use bw_scene_pieces, only: struck_beam
  use bw_tension_modes, only: tension_modes
  use bw_tension_set, only: tension_set
  use bw_tension_system, only: tension_beam
  implicit none (type, external)
  private
  public :: tension_source_of

  type, extends(mode_source), public :: tension_source
    type(tension_set) :: solved                    !! the first modes, from which others are taken
  contains
    procedure :: find => find_among_solved
  end type tension_source

contains

  subroutine tension_source_of(pieces, hub_radius, count, source, monitor)
    !! Make a source of the first `count` modes, and none beyond them.
    type(struck_beam), intent(in) :: pieces
    real(dp), intent(in) :: hub_radius             !! R in l
    integer, intent(in) :: count
    type(tension_source), intent(out) :: source
    class(monitor_type), intent(inout), optional :: monitor   !! none are found where it asks to stop
    type(tension_beam) :: given
    real(dp) :: alpha
    given%beam = pieces%beam
    given%tension = tension_in_pieces(pieces%beam, hub_radius)
    call tension_modes(given, count, pieces%struck, source%solved, monitor)
    source%gamma = pieces%captured%mass%hi
    source%highest = count
    source%struck_at = pieces%position
    source%uniform = .false.
    source%clamped = pieces%beam%root%holds_deflection .and. pieces%beam%root%holds_turning
    alpha = count*acos(-1.0_dp)
    source%decay = 3.0_dp
    if (alpha*source%gamma < 1.0_dp .or. any(pieces%beam%piece%compliance%hi > 0.0_dp) .or. &
        alpha**2 < pieces%beam%spin_squared%hi*given%tension(1, 1)) source%decay = 2.0_dp
    associate (set => source%solved)
      set%gamma = source%gamma
      set%struck_at = pieces%position
      set%uniform = .false.
      set%clamped = source%clamped
      set%body_inertia = pieces%captured%inertia%hi
      set%body_pull = pieces%beam%spin_squared%hi*source%gamma*(pieces%position + hub_radius)
    end associate
  end subroutine tension_source_of

  subroutine find_among_solved(self, number, modes, longest, monitor)
    !! Find the modes of these numbers among those that were solved for. `longest` has no use here: β² has the digits that it
    !! has. Nor has the monitor: all is found already.
    class(tension_source), intent(in) :: self
    integer, intent(in) :: number(:)
    class(mode_set), allocatable, intent(out) :: modes
    real(dp), intent(in), optional :: longest
    class(monitor_type), intent(inout), optional :: monitor
    type(tension_set), allocatable :: found
    integer :: i
    allocate (found)
    associate (all => self%solved)
      call found%take_numbers(all, number)
      found%beam = all%beam
      found%struck_joint = all%struck_joint
      found%body_inertia = all%body_inertia
      found%body_pull = all%body_pull
      allocate (found%piece(size(all%piece)))
      allocate (found%deflection(0:size(all%piece), size(number)), source=all%deflection(:, number))
      allocate (found%turning(0:size(all%piece), size(number)), source=all%turning(:, number))
      do i = 1, size(all%piece)
        found%piece(i) = piece_motions(all%piece(i)%strain(:, number), all%piece(i)%turning(:, number), &
                                       all%piece(i)%slope(:, number), all%piece(i)%deflection(:, number))
      end do
    end associate
    call found%damp(self%damping)
    if (present(longest) .or. present(monitor)) continue
    call move_alloc(found, modes)
  end subroutine find_among_solved

end module bw_tension_source
