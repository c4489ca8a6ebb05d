module bw_case_shares
  !! How long a case takes, how its stages share that time and what memory its modes take, by a rough model: what a progress bar
  !! shows, and what `check` goes on from where it has not the time to run a case to its end.
  use bw_case_modes, only: first_modes, most_to_tolerance
  use bw_kinds, only: dp, i8
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type, part_monitor
  use bw_scene, only: changes_shapes, scene_type, by_pieces
  use bw_timeline, only: comes_back
  implicit none (type, external)
  private
  public :: case_bytes, case_seconds, case_shares, stage_part

  integer, parameter, public :: modes_share = 1, events_share = 2, later_share = 3, histories_share = 4, spectrum_share = 5
    !! events at t = 0, and later ones
  integer, parameter :: shares = 5

  ! seconds, measured on one core
  real(dp), parameter :: mode_seconds = 2.0e-7_dp      ! a mode in closed form
  real(dp), parameter :: piece_seconds = 5.0e-6_dp     ! a mode in a uniform piece
  real(dp), parameter :: cubic_seconds = 5.0e-10_dp    ! the cube of the unknowns of Galerkin's method
  real(dp), parameter :: handed_seconds = 3.0e-7_dp    ! a mode that hands its motion on, and one that receives it
  real(dp), parameter :: shape_seconds = 3.3e-8_dp     ! a mode at a point
  real(dp), parameter :: sum_seconds = 1.0e-7_dp       ! a mode, or half a sample, of a history

contains

  pure function case_shares(scene) result(part)
    !! Of each stage in the time of a case, in all 1.
    type(scene_type), intent(in) :: scene          !! without sweeps
    real(dp) :: part(shares)
    part = stage_seconds(scene)/case_seconds(scene)
  end function case_shares

  pure real(dp) function case_seconds(scene) result(seconds)
    !! Of all stages.
    type(scene_type), intent(in) :: scene          !! without sweeps
    seconds = sum(stage_seconds(scene))
  end function case_seconds

  pure function stage_seconds(scene) result(seconds)
    type(scene_type), intent(in) :: scene
    real(dp) :: seconds(shares)
    real(dp) :: before, after
    before = scene%modes%before
    after = scene%modes%after
    if (.not. allocated(scene%capture)) after = 0.0_dp
    seconds = 0.0_dp
    seconds(modes_share) = seconds_of_modes(scene, before) + seconds_of_modes(scene, after)
    if (allocated(scene%impact)) seconds(events_share) = shape_seconds*before*scene%impact%profile_points
    if (allocated(scene%capture)) seconds(events_share) = seconds(events_share) + handed_seconds*(before + after)
    if (comes_back(scene)) seconds(later_share) = 2.0_dp*handed_seconds*(before + after)
    if (.not. allocated(scene%response)) return
    seconds(histories_share) = sum_seconds*(max(before, after) + 2.0_dp*scene%response%samples)
    if (allocated(scene%spectrum)) seconds(spectrum_share) = seconds_of_spectrum(scene, max(before, after))
  end function stage_seconds

  pure real(dp) function seconds_of_modes(scene, count) result(seconds)
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: count
    seconds = mode_seconds*count
    if (.not. changes_shapes(scene) .or. count == 0.0_dp) return
    seconds = piece_seconds*count*pieces_of_scene(scene)
    if (.not. by_pieces(scene)) seconds = cubic_seconds*unknowns(scene, count)**3
  end function seconds_of_modes

  pure real(dp) function pieces_of_scene(scene) result(pieces)
    !! The number of pieces, a body being the end of one.
    type(scene_type), intent(in) :: scene
    pieces = 1.0_dp
    if (allocated(scene%beam%pieces)) pieces = size(scene%beam%pieces)
    if (allocated(scene%bodies)) pieces = pieces + size(scene%bodies)
  end function pieces_of_scene

  pure real(dp) function unknowns(scene, count)
    !! About how many Galerkin's method has for so many modes.
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: count
    real(dp), parameter :: many = 8.0_dp           ! half waves in a piece, or a tolerance: a first guess may be too few
    real(dp) :: pieces
    pieces = pieces_of_scene(scene)
    unknowns = 10.0_dp + pieces*(16.0_dp + 6.0_dp*min(1.0_dp, count/pieces)) + 1.75_dp*count
    if (by_tolerance(scene%modes)) then
      unknowns = 1.25_dp*unknowns
    else if (pieces > 1.0_dp .and. count > many*pieces) then
      unknowns = 1.5_dp*unknowns
    end if
    if (allocated(scene%shear)) unknowns = 2.0_dp*unknowns
  end function unknowns

  pure real(dp) function most_modes(scene) result(most)
    !! Modes under tension that are found at a time: those that are summed, or that estimates or a tolerance may take.
    type(scene_type), intent(in) :: scene
    most = max(scene%modes%before, scene%modes%after, merge(first_modes, 0, allocated(scene%response)))
    if (by_tolerance(scene%modes)) most = most_to_tolerance(merge(2, 1, allocated(scene%shear)))
  end function most_modes

  pure integer(i8) function case_bytes(scene) result(bytes)
    !! Memory of the modes of a case, while they are found and then: measured, all but what its results take.
    type(scene_type), intent(in) :: scene          !! without sweeps
    integer, parameter :: of_mode = 18, of_piece = 6, of_pair = 4, of_matrix = 7, of_vector = 10, of_search = 1500   ! numbers
    real(dp) :: numbers, before, after
    before = scene%modes%before
    after = scene%modes%after
    if (.not. allocated(scene%capture)) after = 0.0_dp
    numbers = of_mode*(before + after)
    if (by_pieces(scene)) then
      numbers = numbers + (of_search + of_piece*(before + after))*pieces_of_scene(scene)
    else if (changes_shapes(scene)) then
      associate (count => most_modes(scene))
        numbers = numbers + of_matrix*unknowns(scene, count)**2 + of_vector*unknowns(scene, count)*count
      end associate
    end if
    if (allocated(scene%recontact)) numbers = numbers + of_pair*before**2
    bytes = 8*int(numbers, i8)
  end function case_bytes

  pure real(dp) function seconds_of_spectrum(scene, count) result(seconds)
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: count
    real(dp), parameter :: most_lines = 200.0_dp, lines_a_round = 64.0_dp
    real(dp) :: lines, rounds
    lines = min(most_lines, count)
    rounds = aint(lines/lines_a_round) + 1.0_dp
    seconds = 0.1_dp + scene%response%samples*(1.0e-7_dp*(rounds + 2.0_dp) + 4.5e-9_dp*lines*(0.5_dp*rounds + 1.5_dp))
  end function seconds_of_spectrum

  type(part_monitor) function stage_part(monitor, part, stage) result(stage_monitor)
    !! A monitor of one stage of a case.
    class(monitor_type), intent(inout), target :: monitor
    real(dp), intent(in) :: part(:)                !! of `case_shares`
    integer, intent(in) :: stage
    stage_monitor = part_monitor(monitor, sum(part(:stage - 1)), part(stage))
  end function stage_part

end module bw_case_shares
