module bw_kept_blows
  !! Blows that cases share. What a blow leaves follows from the shapes of the modes, the mass ratio and the restitution
  !! alone: cases in which these are the same work it out once.
  use bw_blow, only: blow_of, blow_type
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type
  implicit none (type, external)
  private
  public :: find_blow

  integer, parameter :: most_blows = 128          !! kept at a time
  integer, parameter :: most_numbers = 4096       !! of one that is kept: all together take less than 5 MB

  type :: kept_blow
    type(blow_type) :: blow
    integer :: shapes(2) = 0                      !! `cache_key` of the modes of the beam alone, and of beam and mass
  end type kept_blow

  type, public :: kept_blows
    !! In the order in which they came; the oldest makes room for the newest.
    private
    type(kept_blow), allocatable :: blows(:)
    integer :: found = 0                          !! that were ever kept
  end type kept_blows

contains

  subroutine find_blow(free, loaded, gamma, e, profile_points, monitor, kept, blow)
    !! `blow_of`, remembered where it can be.
    class(mode_set), intent(in) :: free
    class(mode_set), intent(in), optional :: loaded
    real(dp), intent(in) :: gamma, e
    integer, intent(in) :: profile_points
    class(monitor_type), intent(inout) :: monitor  !! nothing is found, nor kept, where it asks to stop
    type(kept_blows), intent(inout) :: kept
    type(blow_type), intent(out) :: blow
    integer :: place, shapes(2)
    shapes = [free%cache_key, 0]
    if (present(loaded)) shapes(2) = loaded%cache_key
    place = place_of(kept, shapes, gamma, e, profile_points)
    if (place > 0) then
      blow = kept%blows(place)%blow
      return
    end if
    call blow_of(free, loaded, gamma, e, profile_points, monitor, blow)
    if (monitor%stop_requested()) return
    if (shapes(1) == 0 .or. (present(loaded) .and. shapes(2) == 0)) return
    if (free%count + size(blow%modal_velocity) + profile_points > most_numbers) return
    if (.not. allocated(kept%blows)) allocate (kept%blows(most_blows))
    place = 1 + mod(kept%found, most_blows)
    kept%blows(place)%blow = blow
    kept%blows(place)%shapes = shapes
    kept%found = kept%found + 1
  end subroutine find_blow

  pure integer function place_of(kept, shapes, gamma, e, profile_points) result(place)
    !! 0: not kept.
    type(kept_blows), intent(in) :: kept
    integer, intent(in) :: shapes(2)
    real(dp), intent(in) :: gamma, e
    integer, intent(in) :: profile_points
    do place = min(kept%found, most_blows), 1, -1
      if (any(kept%blows(place)%shapes /= shapes)) cycle
      associate (blow => kept%blows(place)%blow)
        if (blow%impact%gamma == gamma .and. blow%impact%restitution == e .and. size(blow%velocity_jump) == profile_points) return
      end associate
    end do
  end function place_of

end module bw_kept_blows
